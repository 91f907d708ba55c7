# One Debian package per service, each with its own dependencies (found by dpkg-shlibdeps), so that a service can be put alone
# on another computer: deploy/package.sh, or cpack -G DEB in a build folder. periplus-data carries robots, cameras, scenes and tasks;
# periplus-client what a person types: periplus, periplus-evaluate, periplus-report.
install(DIRECTORY ${CMAKE_SOURCE_DIR}/deploy/robots ${CMAKE_SOURCE_DIR}/deploy/cameras ${CMAKE_SOURCE_DIR}/deploy/scenes ${CMAKE_SOURCE_DIR}/deploy/tasks
  DESTINATION ${CMAKE_INSTALL_DATADIR}/periplus COMPONENT data)
install(PROGRAMS ${CMAKE_SOURCE_DIR}/deploy/fetch-assets.sh DESTINATION ${CMAKE_INSTALL_DATADIR}/periplus COMPONENT data)
# Tasks name robot and scene as deploy/..., in a source tree and here alike.
file(CREATE_LINK . ${CMAKE_BINARY_DIR}/deploy SYMBOLIC)
install(FILES ${CMAKE_BINARY_DIR}/deploy DESTINATION ${CMAKE_INSTALL_DATADIR}/periplus COMPONENT data)

set(periplus_description_vision-server "stereo images to depth, features and camera pose")
set(periplus_description_model-server "keeps environment, robot and object models")
set(periplus_description_nbv-planner "where to look next")
set(periplus_description_posture-generator "whole-body postures that put the cameras there")
set(periplus_description_walk-planner "paths and footsteps")
set(periplus_description_motion-controller "executes footsteps and postures")
set(periplus_description_supervisor "decides what the robot does next")
set(periplus_description_simulator "stands in for the robot: its motion and what its cameras see")
set(periplus_description_client "command line, evaluation and report")
set(periplus_description_data "robots, cameras, scenes and tasks")

set(CPACK_PACKAGE_VENDOR "Periplus")
set(CPACK_PACKAGE_CONTACT "Periplus developers <developers@periplus.invalid>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "A humanoid robot models an unknown object: distributed services over DDS")
set(CPACK_RESOURCE_FILE_LICENSE ${CMAKE_SOURCE_DIR}/LICENSE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL vision-server model-server nbv-planner posture-generator walk-planner motion-controller supervisor simulator client data)
foreach(component ${CPACK_COMPONENTS_ALL})
  string(TOUPPER ${component} upper)
  set(CPACK_DEBIAN_${upper}_PACKAGE_NAME periplus-${component})
  set(CPACK_COMPONENT_${upper}_DESCRIPTION "Periplus: ${periplus_description_${component}}")
  install(FILES ${CMAKE_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/periplus-${component} RENAME copyright COMPONENT ${component})
endforeach()
set(CPACK_DEBIAN_DATA_PACKAGE_ARCHITECTURE all)
set(CPACK_DEBIAN_CLIENT_PACKAGE_DEPENDS periplus-data)
set(CPACK_DEBIAN_SIMULATOR_PACKAGE_DEPENDS "periplus-data, libegl1, libegl-mesa0, libgl1-mesa-dri")  # the renderer is loaded at run time
include(CPack)
