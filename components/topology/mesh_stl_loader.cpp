// SPDX-License-Identifier: LGPL-2.1-or-later
// Reads the triangles of an STL file, ASCII or binary.
//
// An STL file has no shared nodes. Corners with equal digits become one node, and nodes are numbered in the order of their first
// appearance. Triangles with two equal corners have no area: they are left out, and a note counts them. A file is binary if its size is 84
// bytes plus 50 for each declared triangle, whatever its first word.
//
// Source: the format as published by 3D Systems (StereoLithography Interface Specification, 1989); the attributes are SOFA's. VTK's reader
// is not used: its library adds 4 ms to the opening of every scene that writes VTK files.
//
// Example:
// <Node name="root">
//   <MeshSTLLoader name="loader" filename="meshes/block.stl"/>
//   <TriangleSetTopologyContainer name="skin" src="@loader"/>
// </Node>
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cstring>
#include <fstream>
#include <map>
#include <sstream>

#include "framework/mesh/mesh_loader.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

static_assert(std::endian::native == std::endian::little, "binary STL is little-endian");

constexpr std::size_t header_bytes = 84;  ///< 80 of text, 4 of count
constexpr std::size_t record_bytes = 50;  ///< normal and three corners in floats, 2 bytes of attributes

class MeshSTLLoader : public MeshLoader {
 public:
  void declare(DataTable& table) override {
    MeshLoader::declare(table);
    for (const char* name : {"headerSize", "forceBinary", "mergePositionUsingMap"}) table.addVisualOnly(name);
  }

 protected:
  void read(const std::string& file, Mesh& mesh) override {
    name_ = file.substr(file.rfind('/') + 1);
    std::ifstream stream(file, std::ios::binary);
    if (!stream) throw ComponentError(fmt::format("the file {} cannot be opened", file));
    std::ostringstream text;
    text << stream.rdbuf();
    const std::string bytes = std::move(text).str();
    const std::size_t declared = declaredTriangles(bytes);
    if (bytes.size() >= header_bytes && (bytes.size() - header_bytes) == declared * record_bytes)
      readBinary(bytes, declared, mesh);
    else if (bytes.starts_with("solid"))
      readText(bytes, mesh);
    else
      throw ComponentError(
          fmt::format("{} cannot be read as STL: {} bytes, no first word 'solid'", name_, bytes.size()),
          "an ASCII file, or a binary one of 84 bytes and 50 for each triangle");
    if (without_area_ > 0) inform(fmt::format("{} triangles with equal corners were left out", without_area_));
  }

 private:
  static std::size_t declaredTriangles(const std::string& bytes) {
    std::uint32_t count = 0;
    if (bytes.size() >= header_bytes) std::memcpy(&count, bytes.data() + header_bytes - sizeof count, sizeof count);
    return count;
  }

  void readBinary(const std::string& bytes, std::size_t count, Mesh& mesh) {
    for (std::size_t t = 0; t < count; ++t) {
      std::array<float, 12> values;  // the normal, then the corners
      std::memcpy(values.data(), bytes.data() + header_bytes + t * record_bytes, sizeof values);
      std::array<Vec3, 3> corner;
      for (std::size_t k = 0; k < 3; ++k) corner[k] = Vec3(values[3 * k + 3], values[3 * k + 4], values[3 * k + 5]);
      addTriangle(corner, mesh);
    }
  }

  /// Words `vertex x y z` three by three; `facet`, `normal` and the others only have to be where they belong.
  void readText(std::string_view text, Mesh& mesh) {
    std::array<Vec3, 3> corner;
    std::size_t corners = 0, at = 0;
    bool ended = false;
    for (long line = 1; at < text.size(); ++line) {
      const std::size_t end = std::min(text.find('\n', at), text.size());
      std::istringstream words(std::string(text.substr(at, end - at)));
      at = end + 1;
      std::string key;
      words >> key;
      if (key == "vertex") {
        if (corners == 3) fail(line, "a facet has more than three corners");
        for (Index k = 0; k < 3; ++k) corner[corners][k] = readNumber(words, line);
        ++corners;
      } else if (key == "endfacet") {
        if (corners != 3) fail(line, fmt::format("a facet has {} corners", corners));
        addTriangle(corner, mesh);
        corners = 0;
      } else if (key == "endsolid") {
        ended = true;
      } else if (key != "solid" && key != "facet" && key != "outer" && key != "endloop" && !key.empty()) {
        fail(line, fmt::format("'{}' is not a word of STL", key.substr(0, 40)));
      }
    }
    if (!ended) throw ComponentError(fmt::format("{} is cut short", name_), "a last line 'endsolid'");
  }

  double readNumber(std::istringstream& words, long line) const {
    std::string word;
    words >> word;
    double value = 0;
    const auto [stop, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (word.empty() || error != std::errc() || stop != word.data() + word.size())
      fail(line, fmt::format("'{}' is not a number", word.substr(0, 40)));
    return value;
  }

  [[noreturn]] void fail(long line, const std::string& message) const {
    throw ComponentError(fmt::format("{}:{}: {}", name_, line, message), "facets of three lines 'vertex x y z'");
  }

  void addTriangle(const std::array<Vec3, 3>& corner, Mesh& mesh) {
    Triangle triangle;
    for (std::size_t k = 0; k < 3; ++k) {
      if (!corner[k].allFinite())
        throw ComponentError(fmt::format("{}: a corner of triangle {} is not finite", name_, mesh.triangles.size()));
      const auto [it, is_new] = node_at_.try_emplace({corner[k].x(), corner[k].y(), corner[k].z()}, mesh.nodes());
      if (is_new) mesh.position.push_back(corner[k]);
      triangle[k] = it->second;
    }
    if (triangle[0] == triangle[1] || triangle[1] == triangle[2] || triangle[2] == triangle[0])
      ++without_area_;
    else
      mesh.triangles.push_back(triangle);
  }

  std::string name_;
  std::map<std::array<double, 3>, Index> node_at_;
  long without_area_ = 0;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(mesh_stl_loader) {
  factory.add<stroma::MeshSTLLoader>("MeshSTLLoader", "reads the surface of an STL file");
}
