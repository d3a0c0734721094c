// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/mesh/mesh_loader.h"
#include "framework/scene/load.h"
#include "tests/fuzz/fuzz.h"

extern "C" void stroma_register_mesh_gmsh_loader(stroma::Factory& factory);
extern "C" void stroma_register_mesh_obj_loader(stroma::Factory& factory);
extern "C" void stroma_register_mesh_stl_loader(stroma::Factory& factory);

namespace stroma::fuzz {
namespace {

Factory& meshFactory() {
  static Factory instance = [] {
    Factory made;
    stroma_register_mesh_gmsh_loader(made);
    stroma_register_mesh_obj_loader(made);
    stroma_register_mesh_stl_loader(made);
    return made;
  }();
  return instance;
}

}  // namespace

void loadMesh(const std::string& loader, const std::string& ending, std::string_view bytes,
              const std::string& attributes) {
  static Modules modules(meshFactory(), {});
  const std::string scene = "<Node name=\"root\"><" + loader + " name=\"loader\" filename=\"" +
                            fileWith(bytes, ending) + "\" createSubelements=\"true\" " + attributes + "/></Node>";
  try {
    const Scene loaded = loadSceneText(scene, "fuzz.xml", {}, meshFactory(), modules);
    const Mesh& mesh = dynamic_cast<MeshLoader&>(*findComponent(*loaded.root, "/loader")).mesh();
    require(mesh.nodes() > 0, "a mesh without nodes was accepted");
    const std::string error = mesh.firstError();
    require(error.empty(), error);
  } catch (const SceneError& error) {
    require(error.diagnostics().hasErrors(), "refused without a sentence");
  }
}

}  // namespace stroma::fuzz
