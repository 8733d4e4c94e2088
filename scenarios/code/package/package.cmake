# What an installation consists of, and the Debian packages made of it: `gaitcam` to run, `gaitcam-dev` to build against.
# cmake --install BUILD --prefix DIR installs both; cmake --build BUILD --target package makes the packages.
include(CMakePackageConfigHelpers)

set(cmake_folder lib/cmake/gaitcam)
install(EXPORT gaitcam_slam NAMESPACE gaitcam:: DESTINATION ${cmake_folder} FILE gaitcam-slam.cmake COMPONENT dev)
if(GAITCAM_SIM)
  install(EXPORT gaitcam_sim NAMESPACE gaitcam:: DESTINATION ${cmake_folder} FILE gaitcam-sim.cmake COMPONENT dev)
endif()
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/gaitcamConfig.cmake.in ${CMAKE_BINARY_DIR}/gaitcamConfig.cmake
                              INSTALL_DESTINATION ${cmake_folder})
write_basic_package_version_file(${CMAKE_BINARY_DIR}/gaitcamConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_BINARY_DIR}/gaitcamConfig.cmake ${CMAKE_BINARY_DIR}/gaitcamConfigVersion.cmake
        DESTINATION ${cmake_folder} COMPONENT dev)
if(NOT GAITCAM_SIM)
  return()
endif()

# The program, what it reads, and what it says of itself: JSON Schemas for editors, its manual page.
install(PROGRAMS gaitcam DESTINATION bin COMPONENT gaitcam)
install(TARGETS gaitcam_program gaitcam_experiments RUNTIME DESTINATION libexec/gaitcam COMPONENT gaitcam)
foreach(kind scenario study suite matrix)
  set(schema ${CMAKE_BINARY_DIR}/schema/${kind}.schema.json)
  add_custom_command(OUTPUT ${schema} DEPENDS gaitcam_program VERBATIM
                     COMMAND ${CMAKE_COMMAND} -E make_directory ${CMAKE_BINARY_DIR}/schema
                     COMMAND gaitcam_program schema ${kind} > ${schema})
  list(APPEND schemas ${schema})
endforeach()
set(manual ${CMAKE_BINARY_DIR}/gaitcam.1)
add_custom_command(OUTPUT ${manual}.gz DEPENDS gaitcam_program VERBATIM
                   COMMAND gaitcam_program help --man > ${manual}
                   COMMAND gzip -9nf ${manual})
add_custom_target(gaitcam_schemas ALL DEPENDS ${schemas} ${manual}.gz)
install(FILES ${schemas} DESTINATION share/gaitcam/schema COMPONENT gaitcam)
install(FILES ${manual}.gz DESTINATION share/man/man1 COMPONENT gaitcam)
install(DIRECTORY models scenarios DESTINATION share/gaitcam COMPONENT gaitcam
        FILES_MATCHING PATTERN "*.yaml" PATTERN "*.urdf" PATTERN code EXCLUDE)
install(DIRECTORY scenarios/examples DESTINATION share/gaitcam/scenarios COMPONENT gaitcam)
install(DIRECTORY results/baselines DESTINATION share/gaitcam/results COMPONENT gaitcam FILES_MATCHING PATTERN "*.json")
install(FILES README.md DESTINATION share/doc/gaitcam COMPONENT gaitcam)
install(FILES ${CMAKE_CURRENT_LIST_DIR}/completion.bash DESTINATION share/bash-completion/completions RENAME gaitcam
        COMPONENT gaitcam)
install(FILES ${CMAKE_CURRENT_LIST_DIR}/completion.zsh DESTINATION share/zsh/vendor-completions RENAME _gaitcam
        COMPONENT gaitcam)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_CONTACT "The gaitcam developers <gaitcam@example.org>")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL gaitcam dev)
set(CPACK_COMPONENTS_GROUPING ONE_PER_GROUP)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ
    WORLD_EXECUTE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_COMPRESSION_TYPE zstd)

# Linked libraries are found by dpkg-shlibdeps; the others are what EGL, a report's charts and the launcher look for.
set(CPACK_DEBIAN_GAITCAM_PACKAGE_NAME gaitcam)
set(CPACK_DEBIAN_GAITCAM_PACKAGE_SECTION science)
set(CPACK_DEBIAN_GAITCAM_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_GAITCAM_PACKAGE_DEPENDS "libegl-mesa0 | libegl-vendor, libgl1-mesa-dri, libjs-chart.js")
set(CPACK_DEBIAN_GAITCAM_PACKAGE_RECOMMENDS "bubblewrap")  # keeps other people's systems from the truth
set(CPACK_DEBIAN_GAITCAM_PACKAGE_SUGGESTS "gaitcam-dev, opencv-doc, slurm-client")
set(CPACK_DEBIAN_GAITCAM_DESCRIPTION "measures how well visual SLAM works on a walking robot
A MuJoCo humanoid walks, its head camera films with a real exposure, SLAM
systems track the frames, and what they say is scored against the simulator.")
set(CPACK_DEBIAN_DEV_PACKAGE_NAME gaitcam-dev)
set(CPACK_DEBIAN_DEV_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS "libeigen3-dev, libopencv-dev, libceres-dev, libatlas-base-dev, libyaml-cpp-dev, \
libfmt-dev, nlohmann-json3-dev, libssl-dev, libtinyxml2-dev, libavformat-dev, libdeflate-dev, libswscale-dev")
set(CPACK_DEBIAN_DEV_PACKAGE_RECOMMENDS "gaitcam (= ${PROJECT_VERSION}), libmujoco-dev, liburdfdom-dev, libcli11-dev, \
libegl-dev, libgl-dev, libopengl-dev")
set(CPACK_DEBIAN_DEV_DESCRIPTION "headers and libraries of gaitcam, for SLAM systems in C++
With find_package(gaitcam) and gaitcam::slam a shared library or program is
built whose class derives from gaitcam's System.")
include(CPack)
