// SPDX-License-Identifier: LGPL-2.1-or-later
// Reads the voxels of a .raw file, one byte each, as hexahedra or as points.
//
// The file has `header` bytes and then the values of nx ny nz voxels, x fastest. Of those in ROI (xmin ymin zmin xmax ymax zmax,
// both ends included) a voxel counts if its value is in dataValue, or without dataValue if it is not in bgValue; without both lists
// all count. Voxel (i, j, k) is the box from (i, j, k) to (i+1, j+1, k+1) times voxelSize; with generateHexa="false" it is the
// point (i, j, k) times voxelSize. Nodes and cells are numbered x fastest, then y, then z, without those that no voxel uses.
//
// Source: the format, names and attributes are SOFA's.
//
// Example:
// <Node name="root">
//   <VoxelGridLoader name="loader" filename="meshes/two.raw" resolution="2 2 1" voxelSize="0.1 0.1 0.1" bgValue="0"/>
//   <HexahedronSetTopologyContainer src="@loader"/>
// </Node>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <limits>

#include "framework/mesh/topology.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class VoxelGridLoader final : public MeshSource {
 public:
  void declare(DataTable& table) override {
    table.add("filename", filename_).help("file to read").input().alias("segmentationFile").required();
    table.add("resolution", resolution_).help("voxels along x, y and z").required();
    table.add("voxelSize", size_).help("edges of a voxel").unit("m").min(0, false);
    table.add("ROI", region_).help("xmin ymin zmin xmax ymax zmax: first and last voxel to consider");
    table.add("header", header_).help("bytes before the values").min(0);
    table.add("bgValue", background_).help("values of voxels to exclude");
    table.add("dataValue", active_).help("values of voxels to select; by default all except bgValue");
    table.add("generateHexa", makes_cells_).help("false: points instead of hexahedra");
    table.addVisualOnly("segmentationHeader");
    table.add("position", position_).help("nodes").unit("m").output();
    table.add("hexahedra", hexahedra_).help("selected voxels").output();
    table.add("idxInRegularGrid", places_).help("number of each selected voxel among all").output();
  }

  void init() override {
    for (const int n : resolution_)
      if (n < 1) throw ComponentError("resolution has no voxels", "three numbers from 1");
    const double nodes = (resolution_[0] + 1.) * (resolution_[1] + 1.) * (resolution_[2] + 1.);
    if (nodes > std::numeric_limits<int>::max())
      throw ComponentError(fmt::format("resolution asks for {:.3g} nodes", nodes), "fewer than 2^31");
    if (region_.size() != 6) throw ComponentError(fmt::format("ROI has {} numbers", region_.size()), "six");
    readValues();
    position_.clear(), hexahedra_.clear(), places_.clear();
    makes_cells_ ? makeCells() : makePoints();
    if (places_.empty()) throw ComponentError(fmt::format("{} has no selected voxel", filename_.given), "other values or ROI");
  }

 private:
  void readValues() {
    std::ifstream stream(filename_.found, std::ios::binary);
    if (!stream) throw ComponentError(fmt::format("the file {} cannot be opened", filename_.given));
    const auto [nx, ny, nz] = resolution_;
    const std::size_t count = std::size_t(nx) * std::size_t(ny) * std::size_t(nz);
    stream.seekg(0, std::ios::end);
    const auto size = stream.tellg();
    if (size < std::streamoff(count) + header_)
      throw ComponentError(fmt::format("{} has {} bytes, and {} voxels after a header of {} are more", filename_.given,
                                       std::streamoff(size), count, header_));
    values_.resize(count);
    stream.seekg(header_);
    stream.read(reinterpret_cast<char*>(values_.data()), std::streamsize(count));
  }

  bool counts(int value) const {
    const auto has = [value](const std::vector<int>& list) { return std::find(list.begin(), list.end(), value) != list.end(); };
    return active_.empty() ? !has(background_) : has(active_);
  }
  /// Calls visit(i, j, k) for the voxels of the region that count.
  template <class Visit>
  void forVoxels(Visit&& visit) {
    std::array<int, 3> low, high;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low[axis] = std::max(region_[axis], 0);
      if (low[axis] >= resolution_[axis]) throw ComponentError("ROI begins after the last voxel");
      if (region_[axis + 3] < region_[axis])
        throw ComponentError(fmt::format("ROI ends at {} and begins at {}", region_[axis + 3], region_[axis]), "first and last voxels");
      high[axis] = std::max(std::min(region_[axis + 3], resolution_[axis] - 1), low[axis]);
    }
    for (int k = low[2]; k <= high[2]; ++k)
      for (int j = low[1]; j <= high[1]; ++j)
        for (int i = low[0]; i <= high[0]; ++i) {
          const int place = i + resolution_[0] * (j + resolution_[1] * k);
          if (!counts(values_[std::size_t(place)])) continue;
          visit(i, j, k);
          places_.push_back(place);
        }
  }
  Vec3 at(int i, int j, int k) const { return Vec3(i, j, k).cwiseProduct(size_); }

  void makePoints() {
    forVoxels([this](int i, int j, int k) { position_.push_back(at(i, j, k)); });
  }
  void makeCells() {
    static constexpr int corners[8][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
    const int nx = resolution_[0] + 1, ny = resolution_[1] + 1, nz = resolution_[2] + 1;
    const auto number = [&](int i, int j, int k) {
      return std::size_t(i) + std::size_t(nx) * (std::size_t(j) + std::size_t(ny) * std::size_t(k));
    };
    std::vector<Index> nodes(std::size_t(nx) * std::size_t(ny) * std::size_t(nz), -1);
    forVoxels([&](int i, int j, int k) {
      Hexahedron cell;
      for (std::size_t c = 0; c < 8; ++c) {
        cell[c] = Index(number(i + corners[c][0], j + corners[c][1], k + corners[c][2]));
        nodes[std::size_t(cell[c])] = 0;
      }
      hexahedra_.push_back(cell);
    });
    for (int k = 0; k < nz; ++k)
      for (int j = 0; j < ny; ++j)
        for (int i = 0; i < nx; ++i) {
          Index& node = nodes[number(i, j, k)];
          if (node < 0) continue;
          node = Index(position_.size());
          position_.push_back(at(i, j, k));
        }
    for (Hexahedron& cell : hexahedra_)
      for (Index& node : cell) node = nodes[std::size_t(node)];
  }

  static constexpr int last = 0xFFFF;
  FileName filename_;
  std::array<int, 3> resolution_{0, 0, 0};
  std::vector<int> region_{0, 0, 0, last, last, last};
  Vec3 size_ = Vec3::Ones();
  int header_ = 0;
  bool makes_cells_ = true;
  std::vector<int> background_, active_, places_;
  std::vector<unsigned char> values_;
  std::vector<Vec3> position_;
  std::vector<Hexahedron> hexahedra_;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(voxel_grid_loader) {
  factory.add<stroma::VoxelGridLoader>("VoxelGridLoader", "reads the voxels of a .raw file as hexahedra");
}
