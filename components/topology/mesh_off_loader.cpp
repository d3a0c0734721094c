// SPDX-License-Identifier: LGPL-2.1-or-later
// Reads the triangles and quads of an OFF file: the word OFF, three counts (nodes, faces, edges), the nodes, then each face as a count and
// its nodes. Larger faces are cut into triangles around their first node. # starts a comment. Colours, which may follow the nodes of a
// face, are ignored.
//
// Source: the Object File Format of Geomview; the attributes are SOFA's.
//
// Example:
// <Node name="root">
//   <MeshOffLoader name="loader" filename="meshes/block.off"/>
//   <TriangleSetTopologyContainer name="skin" src="@loader"/>
// </Node>
#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <sstream>

#include "framework/mesh/mesh_loader.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class MeshOffLoader : public MeshLoader {
 protected:
  void read(const std::string& file, Mesh& mesh) override {
    std::ifstream stream(file);
    if (!stream) throw ComponentError(fmt::format("the file {} cannot be opened", file));
    std::string line;
    const auto next = [&] {  // a line with something on it
      while (std::getline(stream, line)) {
        line = line.substr(0, line.find('#'));
        if (line.find_first_not_of(" \t\r") != std::string::npos) return true;
      }
      return false;
    };
    const auto cut = [&file] { throw ComponentError(fmt::format("{} is cut short", file), "as many lines as it says"); };
    if (!next() || line.find("OFF") == std::string::npos) throw ComponentError(fmt::format("{} does not begin with OFF", file));
    std::istringstream counts(line.substr(line.find("OFF") + 3));
    long nodes = 0, faces = 0;
    if (!(counts >> nodes >> faces)) {
      if (!next()) cut();
      counts = std::istringstream(line);
      counts >> nodes >> faces;
    }
    constexpr long most = 100'000'000;
    if (nodes < 1 || faces < 0 || nodes > most || faces > most) throw ComponentError(fmt::format("{} has no counts", file));
    for (long i = 0; i < nodes; ++i) {
      if (!next()) cut();
      std::istringstream words(line);
      Vec3 p;
      if (!(words >> p[0] >> p[1] >> p[2])) throw ComponentError(fmt::format("{}: node {} has no three coordinates", file, i));
      mesh.position.push_back(p);
    }
    for (long i = 0; i < faces; ++i) {
      if (!next()) cut();
      addFace(line, file, i, mesh);
    }
  }

 private:
  static void addFace(const std::string& line, const std::string& file, long number, Mesh& mesh) {
    std::istringstream words(line);
    int count = 0;
    words >> count;
    std::vector<Index> face(std::size_t(std::clamp(count, 0, 1000)));
    for (Index& node : face) words >> node;
    if (!words || count < 2) throw ComponentError(fmt::format("{}: face {} is none", file, number), "a count, then as many nodes");
    if (count == 2) {
      mesh.edges.push_back({face[0], face[1]});
    } else if (count == 4) {
      mesh.quads.push_back({face[0], face[1], face[2], face[3]});
    } else {
      for (std::size_t k = 2; k < face.size(); ++k) mesh.triangles.push_back({face[0], face[k - 1], face[k]});
    }
  }
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(mesh_off_loader) {
  factory.add<stroma::MeshOffLoader>("MeshOffLoader", "reads the surface of an OFF file");
}
