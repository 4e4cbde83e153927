# Puts a page's parts together and writes them to OUTPUT as the Page NAME of output/report/page.h:
#   cmake -D NAME=kPage -D PAGE=page.html -D STYLES=a.css -D SCRIPTS=a.js,b.js -D LICENCES=l.html
#     -D OUTPUT=page.cc -P embed_page.cmake
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
file(READ "${LICENCES}" licences)
file(READ "${PAGE}" page)
foreach(part styles scripts licences)
  string(REPLACE "<!-- ${part} -->\n" "${${part}}" page "${page}")
endforeach()
set(data "<!-- data -->\n")
string(FIND "${page}" "${data}" at)
if(at EQUAL -1)
  message(FATAL_ERROR "${PAGE} has no <!-- data -->")
endif()
string(SUBSTRING "${page}" 0 ${at} before)
string(SUBSTRING "${page}" ${at} -1 after)
file(WRITE "${OUTPUT}" "#include \"output/report/page.h\"\n\nnamespace surfit {\n\n"
  "const Page ${NAME} = {R\"page(" "${before}" ")page\", R\"page(" "${after}" ")page\"};\n\n"
  "}  // namespace surfit\n")
