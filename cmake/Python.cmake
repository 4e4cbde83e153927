# SURFIT_BUILD_PYTHON is evaluated at each configuration.
set(SURFIT_BUILD_PYTHON AUTO CACHE STRING
    "Build the Python module: ON, OFF, or AUTO: ON if Python, pybind11 and NumPy are found")
# Prefers Debian's Python, which matches Debian's pybind11 and NumPy, over others in PATH.
if(NOT DEFINED Python3_EXECUTABLE AND EXISTS /usr/bin/python3)
  set(Python3_EXECUTABLE /usr/bin/python3 CACHE FILEPATH "Python interpreter for the module")
endif()
find_package(Python3 QUIET COMPONENTS Interpreter Development.Module NumPy)
find_package(pybind11 2.10 QUIET CONFIG)
if(SURFIT_BUILD_PYTHON STREQUAL "AUTO")
  # A module with sanitizers would need their run-time libraries in Python.
  if(Python3_FOUND AND pybind11_FOUND AND PROJECT_IS_TOP_LEVEL AND NOT SURFIT_SANITIZE)
    set(SURFIT_BUILD_PYTHON ON)
  else()
    set(SURFIT_BUILD_PYTHON OFF)
  endif()
elseif(SURFIT_BUILD_PYTHON)
  find_package(Python3 REQUIRED COMPONENTS Interpreter Development.Module NumPy)
  find_package(pybind11 2.10 REQUIRED CONFIG)
endif()
