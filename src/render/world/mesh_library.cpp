#include "render/world/mesh_library.h"

#include <dlfcn.h>

#include "noiseloom/core/error.h"

namespace noiseloom::render {
namespace {

const MeshLibrary* load_meshes() {
  const auto fail = [] {
    const char* const words = ::dlerror();
    throw EnvironmentError(std::string("the libraries that read and trace meshes, Assimp and Embree, cannot be loaded; "
                                       "the module noiseloom-meshes.so is built where both are found: ") +
                           (words == nullptr ? "no reason was given" : words));
  };
  void* const module = ::dlopen("noiseloom-meshes.so", RTLD_NOW | RTLD_LOCAL);
  if (module == nullptr) fail();
  void* const function = ::dlsym(module, mesh_library_function);
  if (function == nullptr) fail();
  return reinterpret_cast<MeshLibraryFunction>(function)();
}

}  // namespace

const MeshLibrary& mesh_library() {
  static const MeshLibrary* const library = load_meshes();
  return *library;
}

}  // namespace noiseloom::render
