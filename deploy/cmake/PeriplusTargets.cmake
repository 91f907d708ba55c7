# One folder, one target. Sources are what stands in the folder; `x_test.cpp` belongs to the test beside `x.cpp`,
# `main.cpp` to the program, `x_tool.cpp` to a program of its own (`periplus-x`), `bench/` to the benchmarks.

set(PERIPLUS_WARNINGS -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Werror)
if(PERIPLUS_FUZZ)
  set(PERIPLUS_WARNINGS -w)  # they are judged in g++'s builds
elseif(CMAKE_UNITY_BUILD)
  # Where several sources are one unit, g++ takes each for a header that others might include.
  list(APPEND PERIPLUS_WARNINGS -Wno-subobject-linkage)
endif()

set(PERIPLUS_TEST_OPTIONS $<$<CONFIG:Release>:-O1>)  # for tests: a fifth less to compile, nothing to gain from more

function(periplus_target_defaults target)
  target_compile_options(${target} PRIVATE ${PERIPLUS_WARNINGS})
  target_include_directories(${target} PUBLIC ${CMAKE_SOURCE_DIR})
endfunction()

function(_periplus_tests name folder link)
  cmake_parse_arguments(A "" "" "TEST_DEPS;ALSO" ${ARGN})
  file(GLOB tests CONFIGURE_DEPENDS ${folder}/*_test.cpp)
  list(FILTER tests EXCLUDE REGEX "_tool_test\\.cpp$")
  list(APPEND tests ${A_ALSO})
  if(PERIPLUS_TESTS AND tests)
    find_package(GTest REQUIRED)
    include(GoogleTest)
    add_executable(${name}_test ${tests})
    periplus_target_defaults(${name}_test)
    target_compile_options(${name}_test PRIVATE ${PERIPLUS_TEST_OPTIONS})
    target_link_libraries(${name}_test PRIVATE ${link} ${A_TEST_DEPS} GTest::gtest_main)
    target_compile_definitions(${name}_test PRIVATE PERIPLUS_SOURCE_DIR="${CMAKE_SOURCE_DIR}" PERIPLUS_BIN_DIR="${CMAKE_RUNTIME_OUTPUT_DIRECTORY}")
    gtest_discover_tests(${name}_test DISCOVERY_MODE PRE_TEST TEST_PREFIX "${name}." PROPERTIES TIMEOUT 300)
  endif()
endfunction()

# periplus_library(core DEPS … PRIVATE_DEPS … TEST_DEPS …): the library periplus_core of common/core.
function(periplus_library name)
  cmake_parse_arguments(A "" "" "DEPS;PRIVATE_DEPS;TEST_DEPS" ${ARGN})
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cpp ${CMAKE_CURRENT_SOURCE_DIR}/*/*.cpp)
  list(FILTER sources EXCLUDE REGEX "(_test|_tool|_bench|_main|/main)\\.cpp$|/(bench|test|testing|fuzz)/")
  add_library(periplus_${name} STATIC ${sources})
  periplus_target_defaults(periplus_${name})
  target_link_libraries(periplus_${name} PUBLIC ${A_DEPS} PRIVATE ${A_PRIVATE_DEPS})
  _periplus_tests(${name} ${CMAKE_CURRENT_SOURCE_DIR} periplus_${name} TEST_DEPS ${A_TEST_DEPS})
endfunction()

# periplus_service(vision_server DEPS …): the program periplus-vision-server, its library for tests, its configuration
# installed beside it.
function(periplus_service name)
  cmake_parse_arguments(A "" "" "DEPS;TEST_DEPS" ${ARGN})
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cpp)
  list(FILTER sources EXCLUDE REGEX "(_test|_tool|_bench|_main|/main)\\.cpp$")
  add_library(${name}_parts STATIC ${sources})
  periplus_target_defaults(${name}_parts)
  target_link_libraries(${name}_parts PUBLIC ${A_DEPS})
  string(REPLACE "_" "-" program ${name})
  add_executable(${name} main.cpp)
  set_target_properties(${name} PROPERTIES OUTPUT_NAME periplus-${program})
  periplus_target_defaults(${name})
  target_link_libraries(${name} PRIVATE ${name}_parts)
  install(TARGETS ${name} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT ${program})
  install(FILES config/default.yaml DESTINATION ${CMAKE_INSTALL_DATADIR}/periplus/config RENAME ${name}.yaml COMPONENT ${program})
  _periplus_tests(${name} ${CMAKE_CURRENT_SOURCE_DIR} ${name}_parts TEST_DEPS ${A_TEST_DEPS})
endfunction()

# periplus_tool(nbv COMPONENT nbv-planner DEPS …): the program periplus-nbv of nbv_tool.cpp, which `periplus nbv` runs; in the
# package of its service, tested by nbv_tool_test.cpp. Its other sources stand in tool/, with their tests. Only libraries that it uses are loaded: a tool of
# a service's algorithms starts without DDS.
function(periplus_tool name)
  cmake_parse_arguments(A "" "COMPONENT" "DEPS;TEST_DEPS" ${ARGN})
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/tool/*.cpp)
  list(FILTER sources EXCLUDE REGEX "_test\\.cpp$")
  add_library(${name}_tool_parts STATIC ${sources})
  periplus_target_defaults(${name}_tool_parts)
  target_link_libraries(${name}_tool_parts PUBLIC ${A_DEPS})
  add_executable(${name}_tool ${name}_tool.cpp)
  set_target_properties(${name}_tool PROPERTIES OUTPUT_NAME periplus-${name})
  periplus_target_defaults(${name}_tool)
  target_link_libraries(${name}_tool PRIVATE ${name}_tool_parts)
  target_link_options(${name}_tool PRIVATE -Wl,--as-needed)
  install(TARGETS ${name}_tool RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT ${A_COMPONENT})
  _periplus_tests(${name}_tool ${CMAKE_CURRENT_SOURCE_DIR}/tool ${name}_tool_parts TEST_DEPS ${A_TEST_DEPS} ALSO ${name}_tool_test.cpp)
  if(TARGET ${name}_tool_test)
    add_dependencies(${name}_tool_test ${name}_tool)  # it starts the program
  endif()
endfunction()

# periplus_bench(visibility DEPS …): bench/visibility_bench.cpp as visibility_bench, built when asked for
# (`ninja visibility_bench`), where Google Benchmark is installed.
function(periplus_bench name)
  cmake_parse_arguments(A "" "" "DEPS" ${ARGN})
  find_package(benchmark QUIET)
  if(benchmark_FOUND)
    add_executable(${name}_bench EXCLUDE_FROM_ALL bench/${name}_bench.cpp)
    periplus_target_defaults(${name}_bench)
    target_link_libraries(${name}_bench PRIVATE ${A_DEPS} benchmark::benchmark_main)
    target_compile_definitions(${name}_bench PRIVATE PERIPLUS_SOURCE_DIR="${CMAKE_SOURCE_DIR}")
  endif()
endfunction()
