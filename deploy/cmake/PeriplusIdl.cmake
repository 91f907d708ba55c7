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
    list(APPEND seds ${tmp}/${n}.cxx)
    list(APPEND copies COMMAND ${CMAKE_COMMAND} -E copy_if_different ${tmp}/${n}.cxx ${tmp}/${n}.h ${gen})
  endforeach()
  list(REMOVE_DUPLICATES dirs)
  foreach(d ${dirs})
    list(APPEND includes -I ${d})
  endforeach()
  add_custom_command(OUTPUT ${root}/stamp BYPRODUCTS ${outs}
    COMMAND ${CMAKE_COMMAND} -E make_directory ${tmp} ${gen}
    COMMAND "${FASTDDSGEN}" -cs -replace ${includes} -d ${tmp} -t ${tmp} ${abs}
    COMMAND sed -i "s#// m_\\([a-z_A-Z0-9]*\\) com.eprosima.*#// m_\\1#" ${seds}  # drop Java identity hashes: reproducible output
    # Members are read through checks (common/dds/bounded_read.h).
    COMMAND sed -i -e "s|^#include <fastcdr/Cdr.h>|&\\n#include \"common/dds/bounded_read.h\"|" -e "s#dcdr >> \\(m_[A-Za-z0-9_]*\\);#periplus::dds::read_checked(dcdr, \\1);#"
      -e "s#\\(m_[A-Za-z0-9_]*\\) = aux.c_str();#periplus::dds::assign_bounded(\\1, aux);#" ${seds}
    ${copies}
    COMMAND ${CMAKE_COMMAND} -E touch ${root}/stamp
    DEPENDS ${abs} COMMENT "fastddsgen ${target}" VERBATIM)
  add_custom_target(${target}_stamp DEPENDS ${root}/stamp)
  add_library(${target} STATIC ${srcs})
  add_dependencies(${target} ${target}_stamp)
  target_include_directories(${target} SYSTEM PUBLIC ${root})
  target_include_directories(${target} PRIVATE ${CMAKE_SOURCE_DIR})
  target_link_libraries(${target} PUBLIC fastcdr)
endfunction()
