# One library for each folder of layers.txt, linked with what its row says.

if(NOISELOOM_SANITIZE STREQUAL ADDRESS)
  set(noiseloom_sanitizers -fsanitize=address,undefined)
  # Checks of every pointer (alignment, dynamic type, reach) take half of the compiler's time. What reads or writes where it
  # must not is found without them.
  if(NOT NOISELOOM_SANITIZE_POINTERS AND NOT NOISELOOM_SANITIZE_WIDE)
    list(APPEND noiseloom_sanitizers -fno-sanitize=null,alignment,object-size,vptr,pointer-overflow)
  endif()
elseif(NOISELOOM_SANITIZE STREQUAL THREAD)
  set(noiseloom_sanitizers -fsanitize=thread)
elseif(NOISELOOM_SANITIZE)
  message(FATAL_ERROR "NOISELOOM_SANITIZE = ${NOISELOOM_SANITIZE}: accepted: OFF, ADDRESS, THREAD")
endif()

add_library(noiseloom_flags INTERFACE)
target_compile_options(noiseloom_flags INTERFACE
  -Wall -Wextra -Wconversion $<$<NOT:$<BOOL:$<TARGET_PROPERTY:NOISELOOM_MAY_SHADOW>>>:-Wshadow>
  -ffp-contract=off                       # the same bits with and without FMA
  -fno-math-errno                         # lets loops over sqrt be vectorised; changes no result
  $<$<AND:$<BOOL:${CMAKE_UNITY_BUILD}>,$<CXX_COMPILER_ID:GNU>>:-Wno-subobject-linkage>  # takes all files of a batch for headers
  $<$<BOOL:${NOISELOOM_WERROR}>:-Werror>
  ${noiseloom_sanitizers} $<$<BOOL:${NOISELOOM_SANITIZE}>:-fno-sanitize-recover=all -fno-omit-frame-pointer>)
if(NOISELOOM_SANITIZE)  # compilers have no common way to say so
  target_compile_definitions(noiseloom_flags INTERFACE NOISELOOM_SANITIZE_${NOISELOOM_SANITIZE})
endif()
target_link_options(noiseloom_flags INTERFACE ${noiseloom_sanitizers})

# What the words of the third column stand for. Random123 is headers alone.
set(noiseloom_library_threads Threads::Threads)
set(noiseloom_library_fmt fmt::fmt)
set(noiseloom_library_random123)
set(noiseloom_library_hdf5 noiseloom_hdf5)
set(noiseloom_library_xxhash PkgConfig::xxhash)
set(noiseloom_library_mpi MPI::MPI_CXX)
set(noiseloom_library_highway PkgConfig::highway)
set(noiseloom_library_toml)
set(noiseloom_library_oiio ${CMAKE_DL_LIBS})  # a module links it, which is opened when it is needed
set(noiseloom_library_fftw PkgConfig::fftw)
set(noiseloom_library_assimp ${CMAKE_DL_LIBS})  # as with oiio
set(noiseloom_library_embree)

function(noiseloom_layer name uses libraries)
  file(GLOB sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/src/${name}/*.cpp)
  foreach(part IN LISTS noiseloom_parts_of_${name})
    file(GLOB sources_of_part CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/src/${part}/*.cpp)
    list(APPEND sources ${sources_of_part})
  endforeach()
  add_library(noiseloom_${name} STATIC ${sources})
  add_library(noiseloom::${name} ALIAS noiseloom_${name})
  set_target_properties(noiseloom_${name} PROPERTIES EXPORT_NAME ${name})
  target_include_directories(noiseloom_${name} PUBLIC
    $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  target_include_directories(noiseloom_${name} PRIVATE ${PROJECT_SOURCE_DIR}/src)
  target_compile_features(noiseloom_${name} PUBLIC cxx_std_20)
  foreach(use IN LISTS uses)
    if(NOT use MATCHES "/")  # a single header needs no linking
      target_link_libraries(noiseloom_${name} PUBLIC noiseloom_${use})
    endif()
  endforeach()
  foreach(library IN LISTS libraries)
    target_link_libraries(noiseloom_${name} PRIVATE ${noiseloom_library_${library}})
  endforeach()
  target_link_libraries(noiseloom_${name} PRIVATE fmt::fmt $<BUILD_INTERFACE:noiseloom_flags>)
  if(NOISELOOM_BUILD_FUZZERS AND name MATCHES "^(core|files|samples|config|image|measure)$")
    target_compile_options(noiseloom_${name} PRIVATE -fsanitize=fuzzer-no-link)  # counts what an input reaches
  endif()
  install(TARGETS noiseloom_${name} EXPORT noiseloom)
endfunction()

# Every folder of the table, from the bottom up.
set(noiseloom_layers)
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${CMAKE_CURRENT_LIST_DIR}/layers.txt)
file(STRINGS ${CMAKE_CURRENT_LIST_DIR}/layers.txt noiseloom_rows REGEX "^[a-z]")
foreach(row IN LISTS noiseloom_rows)
  string(REPLACE "|" ";" columns "${row}")
  list(GET columns 0 name)
  list(GET columns 1 uses)
  list(GET columns 2 libraries)
  string(STRIP "${name}" name)
  if(name MATCHES "^([a-z]+)/")  # a part of the folder that comes below it in the table
    list(APPEND noiseloom_parts_of_${CMAKE_MATCH_1} ${name})
    continue()
  endif()
  string(REGEX MATCHALL "[a-z0-9_/]+" uses "${uses}")
  string(REGEX MATCHALL "[a-z0-9_/]+" libraries "${libraries}")
  # Without the libraries of images, their folders and all that stand on them are left out.
  set(missing ${libraries})
  list(FILTER missing INCLUDE REGEX "^(oiio|fftw)$")
  set(unbuilt ${uses})
  list(FILTER unbuilt EXCLUDE REGEX "/")
  if(noiseloom_layers)
    list(REMOVE_ITEM unbuilt ${noiseloom_layers})
  endif()
  if(unbuilt OR (missing AND NOT NOISELOOM_IMAGES))
    continue()
  endif()
  list(APPEND noiseloom_layers ${name})
  noiseloom_layer(${name} "${uses}" "${libraries}")
endforeach()
