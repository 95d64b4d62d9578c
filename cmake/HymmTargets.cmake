# Functions that give every target of this package the same language level, warnings and places.

# Our own code: C++17, strict warnings, optional sanitizers.
function(hymm_own_code target)
  target_compile_features(${target} PUBLIC cxx_std_17)
  set_target_properties(${target} PROPERTIES CXX_EXTENSIONS OFF)
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wconversion -Wshadow)
  if(HYMM_WARNINGS_AS_ERRORS)
    target_compile_options(${target} PRIVATE -Werror)
  endif()
  if(HYMM_SANITIZE)
    # A report is a failure: UndefinedBehaviorSanitizer would go on, and the test pass.
    target_compile_options(${target} PRIVATE -fsanitize=${HYMM_SANITIZE} -fno-sanitize-recover=all
      -fno-omit-frame-pointer)
    target_link_options(${target} PRIVATE -fsanitize=${HYMM_SANITIZE})
  endif()
endfunction()

# An executable that `rosrun hymm NAME` finds, in the build tree and when installed.
function(hymm_add_executable name)
  add_executable(${name} ${ARGN})
  target_link_libraries(${name} PRIVATE hymm_ros)
  hymm_own_code(${name})
  # Installed programs find the libraries without the help of the environment.
  set_target_properties(${name} PROPERTIES INSTALL_RPATH "$ORIGIN/..")
  install(TARGETS ${name} RUNTIME DESTINATION ${CATKIN_PACKAGE_BIN_DESTINATION})
endfunction()

# A GoogleTest binary; LABEL (unit, property, monte_carlo, replay) selects it in scripts/test.
function(hymm_add_test name)
  cmake_parse_arguments(ARG "" "LABEL;TIMEOUT" "SOURCES;LIBRARIES" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE hymm_core hymm_test_support ${ARG_LIBRARIES}
    GTest::gmock_main)
  hymm_own_code(${name})
  set_target_properties(${name} PROPERTIES
    RUNTIME_OUTPUT_DIRECTORY "${CMAKE_BINARY_DIR}/tests")
  if(NOT TARGET ${ARG_LABEL}_tests)
    add_custom_target(${ARG_LABEL}_tests)  # so that the tests of one label can be built alone
  endif()
  add_dependencies(${ARG_LABEL}_tests ${name})
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 120)
  endif()
  if(HYMM_SANITIZE)
    math(EXPR ARG_TIMEOUT "10 * ${ARG_TIMEOUT}")  # ThreadSanitizer: up to 13 times as long
  endif()
  gtest_discover_tests(${name}
    DISCOVERY_TIMEOUT 60
    PROPERTIES LABELS "${ARG_LABEL}" TIMEOUT ${ARG_TIMEOUT}
      ENVIRONMENT "HYMM_SOURCE_DIR=${PROJECT_SOURCE_DIR}"
      # Property tests draw the same cases in every run.
      ENVIRONMENT_MODIFICATION "RC_PARAMS=set:seed=1")
endfunction()

# What a command of the package needs around it, in a shell: its messages, its launch files.
function(hymm_add_shell_test name command)
  cmake_parse_arguments(ARG "SERIAL" "LABEL;TIMEOUT" "" ${ARGN})
  add_test(NAME ${name}
    COMMAND ${CMAKE_COMMAND} -E env "HYMM_BUILD_DIR=${CMAKE_BINARY_DIR}"
      "ROS_PACKAGE_PATH=${PROJECT_SOURCE_DIR}:$ENV{ROS_PACKAGE_PATH}"
      bash -c "source '${CATKIN_DEVEL_PREFIX}/setup.bash' && ${command}")
  set_tests_properties(${name} PROPERTIES LABELS ${ARG_LABEL} TIMEOUT ${ARG_TIMEOUT})
  if(ARG_SERIAL)
    set_tests_properties(${name} PROPERTIES RUN_SERIAL TRUE)
  endif()
endfunction()

# NAME_test.py of the present folder. It starts programs of HYMM_BUILD_DIR.
function(hymm_add_python_test name)
  hymm_add_shell_test(${name}
    "unset AMENT_PREFIX_PATH && /usr/bin/python3 '${CMAKE_CURRENT_SOURCE_DIR}/${name}_test.py'"
    ${ARGN})
endfunction()

# NAME.test of the present folder. rostest picks a free port for its own roscore, so these may run
# beside each other and beside a roscore that is already there. Not with --text: rostest then takes
# every test for passed.
function(hymm_add_rostest name)
  find_program(ROSTEST rostest REQUIRED)
  hymm_add_shell_test(rostest_${name}
    "'${ROSTEST}' --results-base-dir '${CMAKE_BINARY_DIR}/rostest' '${CMAKE_CURRENT_SOURCE_DIR}/${name}.test'"
    LABEL ros TIMEOUT 240)
endfunction()
