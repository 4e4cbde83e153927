# Runs DOXYGEN on WORK/Doxyfile. Fails if there are warnings or no front page. Members without a comment are allowed, classes
# and structs without a comment are not.
cmake_minimum_required(VERSION 3.25)

execute_process(COMMAND "${DOXYGEN}" "${WORK}/Doxyfile" COMMAND_ERROR_IS_FATAL ANY)
file(STRINGS "${WORK}/warnings.txt" warnings)
list(FILTER warnings EXCLUDE REGEX "warning: Member .* is not documented")
foreach(warning ${warnings})
  message(SEND_ERROR "${warning}")
endforeach()
file(READ "${WORK}/html/index.html" front_page)
if(NOT front_page MATCHES "find_package" OR NOT front_page MATCHES "classsurfit_1_1Slam.html")
  message(SEND_ERROR "html/index.html lacks the libraries (find_package, surfit::Slam): check front_page.dox")
endif()
