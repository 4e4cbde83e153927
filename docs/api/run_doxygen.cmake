# Runs DOXYGEN on WORK/Doxyfile and fails on its warnings, or without a front page. Of members only the names may say it all;
# every class and struct has a comment.
cmake_minimum_required(VERSION 3.25)

execute_process(COMMAND "${DOXYGEN}" "${WORK}/Doxyfile" COMMAND_ERROR_IS_FATAL ANY)
file(STRINGS "${WORK}/warnings.txt" warnings)
list(FILTER warnings EXCLUDE REGEX "warning: Member .* is not documented")
foreach(warning ${warnings})
  message(SEND_ERROR "${warning}")
endforeach()
file(READ "${WORK}/html/index.html" front_page)
if(NOT front_page MATCHES "find_package" OR NOT front_page MATCHES "classsurfit_1_1Slam.html")
  message(SEND_ERROR "the front page says nothing of the libraries")
endif()
