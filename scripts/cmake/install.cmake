# make install: the program, both libraries, public headers, scenes, and what find_package and pkg-config look for.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

install(TARGETS halocline RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(TARGETS libhalocline libhalocline_shared EXPORT halocline
        ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}
        INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
install(DIRECTORY include/halocline DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} FILES_MATCHING PATTERN "*.h")
install(DIRECTORY scenes DESTINATION ${CMAKE_INSTALL_DATADIR}/halocline FILES_MATCHING PATTERN "*.yaml"
        PATTERN pictures EXCLUDE)

# find_package(Halocline): Halocline::halocline (shared) and Halocline::halocline_static
set(package ${CMAKE_INSTALL_LIBDIR}/cmake/Halocline)
install(EXPORT halocline NAMESPACE Halocline:: FILE HaloclineTargets.cmake DESTINATION ${package})
configure_package_config_file(scripts/cmake/HaloclineConfig.cmake.in HaloclineConfig.cmake INSTALL_DESTINATION ${package}
                              NO_SET_AND_CHECK_MACRO)
write_basic_package_version_file(HaloclineConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/HaloclineConfig.cmake ${PROJECT_BINARY_DIR}/HaloclineConfigVersion.cmake
        DESTINATION ${package})

# pkg-config: what the static library needs is written out as it was found here.
file(RELATIVE_PATH pc_prefix /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
string(REGEX REPLACE "/$" "" pc_prefix ${pc_prefix})
set(private_libraries "")
foreach(library IN LISTS HDF5_C_LIBRARIES MPI_C_LIBRARIES METIS_LIBRARY)
  if(library MATCHES "^(/|-)")
    list(APPEND private_libraries ${library})
  else()
    list(APPEND private_libraries -l${library})
  endif()
endforeach()
list(APPEND private_libraries -lm)
list(REMOVE_DUPLICATES private_libraries)
list(JOIN private_libraries " " private_libraries)
configure_file(scripts/cmake/halocline.pc.in halocline.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/halocline.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
