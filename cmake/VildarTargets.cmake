# One function per kind of target. No target of this project sets compiler flags by itself.

option(VILDAR_WERROR "Treat warnings as errors" OFF)
option(VILDAR_BENCHMARKS "Build the benchmarks (needs Google Benchmark)" OFF)
option(VILDAR_FUZZ "Build the libFuzzer targets of tests/fuzz (needs clang)" OFF)
option(VILDAR_UNIT_TESTS_ONLY "Leave out the tests of whole runs and the studies" OFF)
option(VILDAR_TOGETHER "Compile eight sources of a target at a time: faster as a whole, slower after a change" OFF)
set(VILDAR_SANITIZE "" CACHE STRING "Comma-separated sanitizers, e.g. address,undefined")

find_program(VILDAR_CCACHE ccache)
if(VILDAR_CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  # Without these two ccache stores nothing that is compiled with a precompiled header; with the third it
  # reads that header, 150 MB, once and not for each source.
  set(CMAKE_CXX_COMPILER_LAUNCHER env CCACHE_SLOPPINESS=pch_defines,time_macros CCACHE_INODECACHE=1 ${VILDAR_CCACHE})
endif()

add_library(vildar_settings INTERFACE)
target_compile_features(vildar_settings INTERFACE cxx_std_20)
target_include_directories(vildar_settings INTERFACE ${PROJECT_SOURCE_DIR}/src)
target_compile_options(vildar_settings INTERFACE
  -Wall -Wextra -Wpedantic -Wconversion -Wno-sign-conversion -Wnon-virtual-dtor
  # gcc 12 sees overlaps and overruns in std::string concatenation that are not there (its bugs
  # 105329 and 105651); the sanitizers would find real ones.
  $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>
  $<$<CXX_COMPILER_ID:GNU>:-Wno-stringop-overflow>
  $<$<CXX_COMPILER_ID:GNU>:-Wno-stringop-overread>
  $<$<CXX_COMPILER_ID:GNU>:-Wno-array-bounds>
  # Compiled together, these two would tell of names in the other sources.
  $<$<NOT:$<BOOL:${VILDAR_TOGETHER}>>:-Wshadow>
  $<$<AND:$<BOOL:${VILDAR_TOGETHER}>,$<CXX_COMPILER_ID:GNU>>:-Wno-subobject-linkage>
  $<$<BOOL:${VILDAR_WERROR}>:-Werror>)
if(VILDAR_SANITIZE)
  target_compile_options(vildar_settings INTERFACE
    -fsanitize=${VILDAR_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer -O1 -g1
    # Null and wild pointers stop a program under the address sanitizer too; checked at every access by
    # this one, they add half to the time that everything takes to compile.
    -fno-sanitize=null,alignment,object-size,vptr)
  target_link_options(vildar_settings INTERFACE -fsanitize=${VILDAR_SANITIZE})
endif()

# Most of the time goes into headers and their templates, once per source: eight sources in one take half of it.
# Names in unnamed namespaces must then differ within a room.
function(vildar_compile_together target)
  if(VILDAR_TOGETHER)
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 8)
  endif()
endfunction()

# vildar_library(<room> SOURCES ... [ALONE ...] [PUBLIC libs...] [PRIVATE libs...])
# A room of src/ as a static library vildar::<room>; without SOURCES it is header-only. All rooms share the
# precompiled header of src/CMakeLists.txt. ALONE: sources that read themselves once per instruction set.
function(vildar_library room)
  cmake_parse_arguments(ARG "" "" "SOURCES;ALONE;PUBLIC;PRIVATE" ${ARGN})
  if(ARG_SOURCES)
    add_library(vildar_${room} STATIC ${ARG_SOURCES} ${ARG_ALONE})
    vildar_compile_together(vildar_${room})
    set_source_files_properties(${ARG_ALONE} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
    target_link_libraries(vildar_${room} PUBLIC vildar_settings ${ARG_PUBLIC} PRIVATE ${ARG_PRIVATE})
    target_precompile_headers(vildar_${room} REUSE_FROM vildar_pch)
  else()
    add_library(vildar_${room} INTERFACE)
    target_link_libraries(vildar_${room} INTERFACE vildar_settings ${ARG_PUBLIC})
  endif()
  add_library(vildar::${room} ALIAS vildar_${room})
endfunction()

# vildar_program(<name> SOURCES ... LINK libs...)
function(vildar_program name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINK" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE vildar_settings ${ARG_LINK})
endfunction()

add_custom_target(unit_tests COMMENT "Every program that holds unit tests")

# What a test does itself is quick: compiling it harder takes longer than it saves. At this level gcc 12 takes
# parts of Eigen's matrices for uninitialised.
set(VILDAR_TEST_OPTIONS $<$<CONFIG:Release>:-O1> $<$<CONFIG:Release>:-Wno-maybe-uninitialized>)

# vildar_test(<room> SOURCES ... [LINK libs...] [LABEL unit|pipeline|study] [ENVIRONMENT NAME=VALUE])
# All tests of a room in one GoogleTest program; the label is `unit` unless told.
function(vildar_test room)
  cmake_parse_arguments(ARG "" "LABEL;ENVIRONMENT" "SOURCES;LINK" ${ARGN})
  if(NOT ARG_LABEL)
    set(ARG_LABEL unit)
  endif()
  if(VILDAR_UNIT_TESTS_ONLY AND NOT ARG_LABEL STREQUAL unit)
    return()
  endif()
  add_executable(test_${room} ${ARG_SOURCES})
  if(NOT ARG_LABEL STREQUAL study)
    vildar_compile_together(test_${room})
  endif()
  if(ARG_LABEL STREQUAL unit)
    add_dependencies(unit_tests test_${room})
  endif()
  target_link_libraries(test_${room} PRIVATE vildar_settings vildar_test_support ${ARG_LINK} GTest::gtest_main)
  target_compile_options(test_${room} PRIVATE ${VILDAR_TEST_OPTIONS})
  target_precompile_headers(test_${room} REUSE_FROM vildar_test_pch)
  set(timeout_s 600)
  if(ARG_LABEL STREQUAL study)
    set(timeout_s 7200)
  endif()
  set(properties LABELS ${ARG_LABEL} TIMEOUT ${timeout_s})
  if(ARG_ENVIRONMENT)
    list(APPEND properties ENVIRONMENT ${ARG_ENVIRONMENT})
  endif()
  gtest_discover_tests(test_${room} DISCOVERY_MODE PRE_TEST PROPERTIES ${properties})
endfunction()

# vildar_benchmark(<name> SOURCES ... LINK libs...): Google Benchmark; built only with VILDAR_BENCHMARKS.
function(vildar_benchmark name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINK" ${ARGN})
  if(VILDAR_BENCHMARKS)
    add_executable(bench_${name} ${ARG_SOURCES})
    target_link_libraries(bench_${name} PRIVATE vildar_settings ${ARG_LINK} benchmark::benchmark_main)
  endif()
endfunction()

# vildar_fuzz_target(<name> LINK libs...): <name>_fuzz.cpp as a libFuzzer program fuzz_<name> with VILDAR_FUZZ,
# else as a unit test that replays tests/fuzz/corpus/<name>.
function(vildar_fuzz_target name)
  cmake_parse_arguments(ARG "" "" "LINK" ${ARGN})
  if(VILDAR_FUZZ)
    add_executable(fuzz_${name} ${name}_fuzz.cpp)
    target_link_options(fuzz_${name} PRIVATE -fsanitize=fuzzer)
  else()
    add_executable(fuzz_${name} ${name}_fuzz.cpp replay.cpp)
    add_dependencies(unit_tests fuzz_${name})
    add_test(NAME fuzz.${name} COMMAND fuzz_${name} ${CMAKE_CURRENT_SOURCE_DIR}/corpus/${name})
    set_tests_properties(fuzz.${name} PROPERTIES LABELS unit TIMEOUT 120)
  endif()
  target_link_libraries(fuzz_${name} PRIVATE vildar_settings vildar_fuzz_input ${ARG_LINK})
endfunction()
