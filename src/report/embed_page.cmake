# Puts the page's parts together and writes them to OUTPUT as the C++ strings of report/page.h:
#   cmake -D PAGE=page.html -D STYLES=a.css -D SCRIPTS=a.js,b.js -D OUTPUT=page.cc -P embed_page.cmake
cmake_minimum_required(VERSION 3.25)

function(read_all files tag result)
  set(all)
  string(REPLACE "," ";" files "${files}")
  foreach(file ${files})
    file(READ "${file}" text)
    if(text MATCHES "</${tag}")
      message(FATAL_ERROR "${file} holds </${tag}: it would end there")
    endif()
    string(APPEND all "<${tag}>\n${text}</${tag}>\n")
  endforeach()
  set(${result} "${all}" PARENT_SCOPE)
endfunction()

read_all("${STYLES}" style styles)
read_all("${SCRIPTS}" script scripts)
file(READ "${PAGE}" page)
string(REPLACE "<!-- styles -->" "${styles}" page "${page}")
string(REPLACE "<!-- scripts -->" "${scripts}" page "${page}")
set(runs "<!-- runs -->")
string(FIND "${page}" "${runs}" at)
if(at EQUAL -1)
  message(FATAL_ERROR "${PAGE} has no ${runs}")
endif()
string(SUBSTRING "${page}" 0 ${at} before)
string(SUBSTRING "${page}" ${at} -1 after)
file(WRITE "${OUTPUT}" "#include \"report/page.h\"\n\nnamespace surfit {\n\n"
  "const char kPageBeforeRuns[] = R\"page(" "${before}" ")page\";\n\n"
  "const char kPageAfterRuns[] = R\"page(" "${after}" ")page\";\n\n"
  "}  // namespace surfit\n")
