# `cpack` in a build with the preset `package` creates the Debian packages libsurfit0,
# libsurfit-dev, surfit-tools and python3-surfit. tests/package/lintian.sh checks them.
if(NOT BUILD_SHARED_LIBS)
  return()
endif()
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGING_INSTALL_PREFIX "${CMAKE_INSTALL_PREFIX}")
# Packages need a contact address. Surfit has none, so this one is invalid by RFC 2606.
set(CPACK_PACKAGE_CONTACT "Surfit developers <developers@surfit.invalid>")
set(CPACK_COMPONENTS_ALL library dev)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_ENABLE_COMPONENT_DEPENDS OFF)
# Library dependencies come from the linked libraries. Surfit's own libraries are in the build folder.
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS "${PROJECT_BINARY_DIR}/src")
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)
set(same_version "(= ${PROJECT_VERSION})")
set(about "Surfit turns RGB-D video into a camera trajectory and a surfel map
on an ordinary CPU.")

set(CPACK_DEBIAN_LIBRARY_PACKAGE_NAME libsurfit0)
set(CPACK_DEBIAN_LIBRARY_PACKAGE_SECTION libs)
set(CPACK_DEBIAN_LIBRARY_DESCRIPTION "dense RGB-D SLAM - shared libraries
${about}
This package has the libraries that the programs, the Python module and
other programs link.")
# Loaded at run time for cameras and videos, not linked.
set(CPACK_DEBIAN_LIBRARY_PACKAGE_SUGGESTS "libopenni2-0, libopencv-videoio406")
# The trigger runs ldconfig. Without the two names of missing scripts, CPack would also generate
# scripts that call ldconfig.
set(CPACK_DEBIAN_LIBRARY_PACKAGE_CONTROL_EXTRA "${PROJECT_SOURCE_DIR}/cmake/debian/triggers"
  "${PROJECT_BINARY_DIR}/no/postinst" "${PROJECT_BINARY_DIR}/no/postrm")

set(CPACK_DEBIAN_DEV_PACKAGE_NAME libsurfit-dev)
set(CPACK_DEBIAN_DEV_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEV_DESCRIPTION "dense RGB-D SLAM - headers for C++
${about}
This package has the headers, Ceres functors, and what CMake and pkg-config
need to find them.")
set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS "libsurfit0 ${same_version}, libeigen3-dev, libceres-dev")

if(SURFIT_BUILD_TOOLS)
  list(APPEND CPACK_COMPONENTS_ALL tools)
  set(CPACK_DEBIAN_TOOLS_PACKAGE_NAME surfit-tools)
  set(CPACK_DEBIAN_TOOLS_PACKAGE_SECTION science)
  set(CPACK_DEBIAN_TOOLS_DESCRIPTION "dense RGB-D SLAM - programs
${about}
This package has the programs: SLAM, scans in fragments, batches,
refinement, meshes, registration, evaluation, simulation.")
  set(CPACK_DEBIAN_TOOLS_PACKAGE_DEPENDS "libsurfit0 ${same_version}")
  set(CPACK_DEBIAN_TOOLS_PACKAGE_SUGGESTS "snakemake")
endif()
if(SURFIT_BUILD_PYTHON)
  list(APPEND CPACK_COMPONENTS_ALL python)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-surfit)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
  math(EXPR next_minor "${Python3_VERSION_MINOR} + 1")
  # The module depends on one NumPy ABI (/usr/share/numpy3/versions). NumPy 2 has another package.
  execute_process(OUTPUT_VARIABLE numpy_abi OUTPUT_STRIP_TRAILING_WHITESPACE
    COMMAND_ERROR_IS_FATAL ANY COMMAND "${Python3_EXECUTABLE}" -c "
try: from numpy._core import _multiarray_umath as m
except ImportError: from numpy.core import _multiarray_umath as m
major, abi = divmod(m._get_ndarray_c_version(), 0x1000000)
print('python3-numpy%s-abi%d' % ('' if major == 1 else major, abi))")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS "libsurfit0 ${same_version}, python3-numpy, \
${numpy_abi}, python3 (>= 3.${Python3_VERSION_MINOR}~), \
python3 (<< 3.${next_minor})")
  set(CPACK_DEBIAN_PYTHON_DESCRIPTION "dense RGB-D SLAM - Python module
${about}
This package has the Python module, with types.")
endif()

# Each package contains its licence and the notices of its components. One package contains lintian
# overrides.
execute_process(COMMAND date --rfc-email --utc --date=@0 OUTPUT_VARIABLE date
  OUTPUT_STRIP_TRAILING_WHITESPACE)
set(debian "${PROJECT_BINARY_DIR}/debian")
configure_file(cmake/debian/changelog.in "${debian}/changelog" @ONLY)
execute_process(COMMAND gzip -9nc "${debian}/changelog" OUTPUT_FILE "${debian}/changelog.gz")
foreach(component ${CPACK_COMPONENTS_ALL})
  string(TOUPPER ${component} upper)
  set(package ${CPACK_DEBIAN_${upper}_PACKAGE_NAME})
  install(FILES cmake/debian/copyright "${debian}/changelog.gz" third_party_notes.md
    DESTINATION "share/doc/${package}" COMPONENT ${component})
endforeach()
install(FILES cmake/debian/overrides-libsurfit0 RENAME libsurfit0
  DESTINATION share/lintian/overrides COMPONENT library)
include(CPack)
