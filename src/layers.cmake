# One library per layer (folder). A layer links only what stands below it; tests/core/layers_test.py checks the includes.

add_library(noiseloom_flags INTERFACE)
target_compile_options(noiseloom_flags INTERFACE
  -Wall -Wextra -Wconversion $<$<NOT:$<BOOL:$<TARGET_PROPERTY:NOISELOOM_MAY_SHADOW>>>:-Wshadow>
  -ffp-contract=off                       # the same bits with and without FMA
  -fno-math-errno                         # lets loops over sqrt be vectorised; changes no result
  $<$<BOOL:${CMAKE_UNITY_BUILD}>:-Wno-subobject-linkage>  # takes all files of a batch for headers
  $<$<BOOL:${NOISELOOM_WERROR}>:-Werror>
  $<$<BOOL:${NOISELOOM_SANITIZE}>:-fsanitize=address,undefined -fno-sanitize-recover=all -fno-omit-frame-pointer>)
target_link_options(noiseloom_flags INTERFACE
  $<$<BOOL:${NOISELOOM_SANITIZE}>:-fsanitize=address,undefined>)

# noiseloom_layer(NAME DEPENDS public libraries... PRIVATE private libraries...)
function(noiseloom_layer name)
  cmake_parse_arguments(arg "" "" "DEPENDS;PRIVATE" ${ARGN})
  file(GLOB sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/src/${name}/*.cpp)
  add_library(noiseloom_${name} STATIC ${sources})
  add_library(noiseloom::${name} ALIAS noiseloom_${name})
  set_target_properties(noiseloom_${name} PROPERTIES EXPORT_NAME ${name})
  target_include_directories(noiseloom_${name} PUBLIC
    $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  target_include_directories(noiseloom_${name} PRIVATE ${PROJECT_SOURCE_DIR}/src)
  target_compile_features(noiseloom_${name} PUBLIC cxx_std_20)
  target_link_libraries(noiseloom_${name} PUBLIC ${arg_DEPENDS} PRIVATE ${arg_PRIVATE} $<BUILD_INTERFACE:noiseloom_flags>)
  install(TARGETS noiseloom_${name} EXPORT noiseloom)
endfunction()
