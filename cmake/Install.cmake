# Installation and export for find_package(surfit) and pkg-config. Each component becomes a Debian
# package, see DebianPackages.cmake.
include(CMakePackageConfigHelpers)
set(SURFIT_CMAKE_DIR "${CMAKE_INSTALL_LIBDIR}/cmake/surfit")
install(TARGETS surfit_core surfit_registration surfit_mapping surfit_io surfit_app surfit
  EXPORT surfit-targets
  LIBRARY COMPONENT library NAMELINK_COMPONENT dev
  ARCHIVE COMPONENT dev
  FILE_SET HEADERS COMPONENT dev)
install(TARGETS surfit_cost_functions EXPORT surfit-targets
  FILE_SET HEADERS DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}/surfit" COMPONENT dev)
install(EXPORT surfit-targets NAMESPACE surfit:: DESTINATION "${SURFIT_CMAKE_DIR}" COMPONENT dev)
configure_package_config_file(cmake/surfit-config.cmake.in "${PROJECT_BINARY_DIR}/surfit-config.cmake"
  INSTALL_DESTINATION "${SURFIT_CMAKE_DIR}")
write_basic_package_version_file("${PROJECT_BINARY_DIR}/surfit-config-version.cmake"
  COMPATIBILITY SameMinorVersion)
install(FILES "${PROJECT_BINARY_DIR}/surfit-config.cmake" "${PROJECT_BINARY_DIR}/surfit-config-version.cmake"
  DESTINATION "${SURFIT_CMAKE_DIR}" COMPONENT dev)

# Static libraries list their dependencies for `pkg-config --static`. Shared libraries do not need
# this.
if(BUILD_SHARED_LIBS)
  set(SURFIT_PC_REQUIRES "")
  set(SURFIT_PC_LIBS "")
else()
  set(SURFIT_PC_REQUIRES "libglog libturbojpeg libpng libtiff-4 liblzf liblz4 libzstd sqlite3 libdeflate tbb")
  set(SURFIT_PC_LIBS "-lceres -lopencv_features2d -lopencv_imgproc \
-lopencv_core -lmeshoptimizer -lbz2 -ldl -pthread")
endif()
file(RELATIVE_PATH SURFIT_PREFIX_FROM_PC "/${CMAKE_INSTALL_LIBDIR}/pkgconfig" "/")
configure_file(cmake/surfit.pc.in "${PROJECT_BINARY_DIR}/surfit.pc" @ONLY)
install(FILES "${PROJECT_BINARY_DIR}/surfit.pc"
  DESTINATION "${CMAKE_INSTALL_LIBDIR}/pkgconfig" COMPONENT dev)
