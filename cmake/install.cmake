# What `cmake --install` and CPack's Debian packages hold: burnish (the programs and a service), libburnish-dev (the client).
include(CMakePackageConfigHelpers)

install(TARGETS burnishd burnish_cli RUNTIME COMPONENT programs)
install(FILES README.md CHANGELOG.md docs/api.md docs/operations.md DESTINATION "${CMAKE_INSTALL_DOCDIR}" COMPONENT programs)
install(FILES docker/prometheus/alerts.yaml DESTINATION "${CMAKE_INSTALL_DOCDIR}/prometheus" COMPONENT programs)
# These name the prefix, which is known when they are installed.
set(package "${CMAKE_CURRENT_LIST_DIR}/package")
configure_file("${package}/install_programs.cmake.in" "${PROJECT_BINARY_DIR}/install_programs.cmake" @ONLY)
install(SCRIPT "${PROJECT_BINARY_DIR}/install_programs.cmake" COMPONENT programs)

set_target_properties(burnish_client PROPERTIES EXPORT_NAME client)
set_target_properties(burnish_proto PROPERTIES EXPORT_NAME proto)
install(TARGETS burnish_client burnish_proto EXPORT burnish ARCHIVE COMPONENT client)
install(FILES client/smoothing_client.h client/call_options.h client/result.h
        DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}/burnish/client" COMPONENT client)
install(DIRECTORY "${PROJECT_BINARY_DIR}/proto/generated/burnish/v1" DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}/burnish"
        COMPONENT client FILES_MATCHING PATTERN "*.h")
install(DIRECTORY proto/burnish DESTINATION "${CMAKE_INSTALL_DATADIR}/burnish/proto" COMPONENT client)
install(DIRECTORY client/examples DESTINATION "${CMAKE_INSTALL_DATADIR}/doc/libburnish-dev" COMPONENT client)

set(config "${CMAKE_INSTALL_LIBDIR}/cmake/Burnish")
configure_package_config_file("${package}/BurnishConfig.cmake.in" "${PROJECT_BINARY_DIR}/BurnishConfig.cmake"
                              INSTALL_DESTINATION "${config}" NO_SET_AND_CHECK_MACRO)
write_basic_package_version_file("${PROJECT_BINARY_DIR}/BurnishConfigVersion.cmake" COMPATIBILITY SameMinorVersion)
install(FILES "${PROJECT_BINARY_DIR}/BurnishConfig.cmake" "${PROJECT_BINARY_DIR}/BurnishConfigVersion.cmake"
        DESTINATION "${config}" COMPONENT client)
install(EXPORT burnish NAMESPACE burnish:: FILE BurnishTargets.cmake DESTINATION "${config}" COMPONENT client)
file(RELATIVE_PATH prefix_from_pkgconfig "${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig" "${CMAKE_INSTALL_PREFIX}")
configure_file("${package}/burnish.pc.in" "${PROJECT_BINARY_DIR}/burnish.pc" @ONLY)
install(FILES "${PROJECT_BINARY_DIR}/burnish.pc" DESTINATION "${CMAKE_INSTALL_LIBDIR}/pkgconfig" COMPONENT client)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME burnish)
set(CPACK_PACKAGE_VENDOR "Burnish")
set(CPACK_PACKAGE_CONTACT "The authors of Burnish <burnish@localhost>")
set(CPACK_SET_DESTDIR ON) # files below /etc
set(CPACK_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL programs client)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_PROGRAMS_PACKAGE_NAME burnish)
set(CPACK_DEBIAN_PROGRAMS_DESCRIPTION "${PROJECT_DESCRIPTION}
 burnishd smooths OBJ, Draco, PLY, STL, OFF and glTF meshes for callers of gRPC and HTTP, as a service of systemd;
 burnish does it on the command line.")
set(CPACK_DEBIAN_PROGRAMS_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PROGRAMS_PACKAGE_DEPENDS init-system-helpers)
set(CPACK_DEBIAN_PROGRAMS_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_PROGRAMS_PACKAGE_CONTROL_EXTRA
  "${package}/postinst" "${package}/prerm" "${package}/postrm" "${package}/conffiles")
set(CPACK_DEBIAN_CLIENT_PACKAGE_NAME libburnish-dev)
set(CPACK_DEBIAN_CLIENT_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_CLIENT_DESCRIPTION "C++ client of Burnish: library, headers, contract and examples
 For find_package(Burnish) and pkg-config. Calls a burnishd over gRPC, with retries and progress.")
# What find_package(gRPC) of Debian 12 looks for.
set(CPACK_DEBIAN_CLIENT_PACKAGE_DEPENDS
  "libgrpc++-dev, protobuf-compiler-grpc, libprotobuf-dev, protobuf-compiler, libabsl-dev, libc-ares-dev, libre2-dev, libssl-dev, zlib1g-dev")
include(CPack)
