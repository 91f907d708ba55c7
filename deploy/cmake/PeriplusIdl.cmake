# periplus_idl(target FILES a.idl b.idl): C++ types of all files from one fastddsgen call (one JVM start; no race on
# included IDL), generated into a private folder and copied only when changed, so that touching one IDL rebuilds
# only what differs. Headers are included as "idl/<name>.h".
find_package(fastcdr REQUIRED)
find_program(FASTDDSGEN fastddsgen REQUIRED)

function(periplus_idl target)
  cmake_parse_arguments(A "" "" "FILES" ${ARGN})
  set(root ${CMAKE_BINARY_DIR}/idl_gen)
  set(gen ${root}/idl)
  set(tmp ${root}/tmp)
  foreach(f ${A_FILES})
    get_filename_component(p ${f} ABSOLUTE)
    get_filename_component(n ${f} NAME_WE)
    get_filename_component(d ${p} DIRECTORY)
    list(APPEND dirs ${d})
    list(APPEND abs ${p})
    list(APPEND srcs ${gen}/${n}.cxx)
    list(APPEND outs ${gen}/${n}.cxx ${gen}/${n}.h)
    list(APPEND generated ${tmp}/${n}.cxx)
    list(APPEND copies COMMAND ${CMAKE_COMMAND} -E copy_if_different ${tmp}/${n}.cxx.checked ${gen}/${n}.cxx
                       COMMAND ${CMAKE_COMMAND} -E copy_if_different ${tmp}/${n}.h ${gen})
  endforeach()
  list(REMOVE_DUPLICATES dirs)
  foreach(d ${dirs})
    list(APPEND includes -I ${d})
  endforeach()
  add_custom_command(OUTPUT ${root}/stamp BYPRODUCTS ${outs}
    COMMAND ${CMAKE_COMMAND} -E make_directory ${tmp} ${gen}
    COMMAND "${FASTDDSGEN}" -cs -replace ${includes} -d ${tmp} -t ${tmp} ${abs}
    COMMAND awk -f ${CMAKE_SOURCE_DIR}/idl/checked_reads.awk ${abs} ${generated}
    ${copies}
    COMMAND ${CMAKE_COMMAND} -E touch ${root}/stamp
    DEPENDS ${abs} ${CMAKE_SOURCE_DIR}/idl/checked_reads.awk COMMENT "fastddsgen ${target}" VERBATIM)
  add_custom_target(${target}_stamp DEPENDS ${root}/stamp)
  add_library(${target} STATIC ${srcs})
  add_dependencies(${target} ${target}_stamp)
  target_include_directories(${target} SYSTEM PUBLIC ${root})
  target_include_directories(${target} PRIVATE ${CMAKE_SOURCE_DIR})
  target_link_libraries(${target} PUBLIC fastcdr)
endfunction()
