// SPDX-License-Identifier: LGPL-2.1-or-later
// UniformMass: the same mass m at every node, whatever the cells around it.
//
//   M = m I,  m = vertexMass, or totalMass / (number of nodes)
//
// `vertexMass` takes precedence if both are given. With `indices` or `localRange` only these nodes have mass. On a mesh with
// cells of different sizes the density is not uniform: use DiagonalMass or MeshMatrixMass for that.
//
// A rigid frame (template Rigid3) has also an inertia about its centre, `inertia` [kg m^2], in its own axes J0; in fixed
// axes it is J = R J0 R^T, and its momentum J w changes with the torque alone:
//
//   J w' + w x J w = torque
//
// SOFA gives the inertia by the mass: vertexMass="m V I" with the volume V, which is not used, and I = J0/m of nine
// numbers, or a `filename` with lines `mass m`, `volm V` and `inrt` and nine numbers. Without any J0 is m times the unit
// matrix [m^2], as there. With turns="false" J0 stays in fixed axes and w x J w is left out, as SOFA computes it.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerExplicitSolver/>
//   <MechanicalObject position="0 0 0  1 0 0  0 1 0"/>
//   <UniformMass totalMass="3"/>
// </Node>
#include <fmt/format.h>

#include <algorithm>
#include <fstream>

#include "components/mechanics/frame_inertia.h"
#include "framework/algebra/parallel.h"
#include "framework/mechanics/mass.h"
#include "framework/mechanics/node_indices.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class UniformMass final : public Mass {
 public:
  void declare(DataTable& table) override {
    Mass::declare(table);
    table.add("vertexMass", vertex_mass_)
        .recompiled()
        .help(
            "mass of each node; wins over totalMass; of frames also the mass, the volume and nine numbers of "
            "inertia/mass")
        .unit("kg");
    table.add("totalMass", total_mass_).recompiled().help("mass of all nodes together").unit("kg").min(0, false);
    frames_.declare(table);
    table.add("turns", turns_).help("the inertia of a frame rotates with it; false: it is constant in fixed axes, as in SOFA");
    table.add("filename", file_name_).input().help("mass, volume and inertia of a frame, a file of SOFA's");
    table.add("indices", indices_).help("nodes that have mass; all by default");
    table.add("localRange", range_).help("first and last node that have mass; -1 -1: all");
    for (const char* without_effect : {"preserveTotalMass", "compute_mapping_inertia"})
      table.addVisualOnly(without_effect);
  }

  void init() override {
    Mass::init();
    const std::vector<Index> nodes = chosenNodes();
    const bool by_file = !file_name_.given.empty() && file_name_.given != "unused";
    if (by_file) readFile();
    const bool by_vertex = data().find("vertexMass")->isSet() || by_file, by_total = data().find("totalMass")->isSet();
    readVertexMass();
    if (!by_vertex && !by_total)
      warn("neither totalMass nor vertexMass is given: the total mass is set to 1 kg", "give totalMass [kg]");
    if (by_vertex && by_total) warn("both vertexMass and totalMass are given: vertexMass is used", "remove totalMass");
    if (by_vertex) {
      total_mass_ = mass_ * double(nodes.size());
    } else {
      mass_ = total_mass_ / double(nodes.size());
      if (!by_file) vertex_mass_ = {mass_};
    }
    std::vector<double> masses(std::size_t(state().nodes()), 0.0);
    for (Index node : nodes) masses[std::size_t(node / state().rows_per_node)] = mass_;
    everywhere_ = nodes.size() == masses.size() && !state().hasFrames();
    setMasses(masses);
  }

  const std::vector<double>& lumped() const override { return masses_; }
  bool isDiagonal() const override { return true; }

  void addProduct(ConstRows p, double factor, Rows out) const override {
    if (!everywhere_) return Mass::addProduct(p, factor, out);
    const ConstRows from = state().segment(p);
    const Rows to = state().segment(out);
    forPieces([&](Index first, Index count) { axpy(factor * mass_, from.segment(first, count), to.segment(first, count)); });
  }
  bool setsProducts(Index rows) const override { return everywhere_ && state().size() == rows; }
  void setProduct(ConstRows p, double factor, Rows out) const override {
    const double each = factor * mass_;
    forPieces([&](Index first, Index count) {
      const double* __restrict from = p.segment(first, count).data;
      double* __restrict to = out.segment(first, count).data;
#pragma omp simd
      for (std::size_t i = 0; i < std::size_t(count) * row_doubles; ++i) to[i] = each * from[i];
    });
  }

 protected:
  bool takesAllRows() const override { return true; }

 private:
  /// body(first row, rows)
  template <class Body>
  void forPieces(Body&& body) const {
    constexpr Index piece_rows = 16384;
    const Index size = state().size();
    parallelFor(int((size + piece_rows - 1) / piece_rows), [&](int piece) {
      body(piece * piece_rows, std::min(piece_rows, size - piece * piece_rows));
    });
  }
  /// m, or of frames m, V and I.
  void readVertexMass() {
    const std::size_t count = vertex_mass_.size();
    if (count != 1 && !(state().hasFrames() && count == 11))
      throw ComponentError(fmt::format("vertexMass has {} numbers", count),
                           state().hasFrames() ? "1 number, or 11: mass, volume and inertia/mass" : "1 number");
    mass_ = vertex_mass_[0];
    if (!(mass_ > 0) || !std::isfinite(mass_))
      throw ComponentError(fmt::format("vertexMass is {}", mass_), "a value > 0 kg");
    per_mass_ = count == 11 ? matrixOf(vertex_mass_.data() + 2) : Mat3(Mat3::Identity());
  }

  void readFile() {
    if (!state().hasFrames()) throw ComponentError("filename is of rigid frames", "vertexMass or totalMass");
    std::ifstream file(file_name_.found);
    vertex_mass_ = {1, 1, 1, 0, 0, 0, 1, 0, 0, 0, 1};
    bool known = false;
    for (std::string word; file >> word;) {
      const bool is_mass = word == "mass" || word == "vertexMass";
      if (!is_mass && word != "volm" && word != "inrt") continue;
      double* at = vertex_mass_.data() + (is_mass ? 0 : word == "volm" ? 1 : 2);
      for (double* end = at + (word == "inrt" ? 9 : 1); at != end; ++at)
        if (!(file >> *at)) throw ComponentError(file_name_.found + ": " + word + " is not followed by its numbers");
      known = true;
    }
    if (!known) throw ComponentError(file_name_.found + " has no mass", "lines: mass m, volm V, inrt and nine numbers");
  }

  void setMasses(const std::vector<double>& masses) {
    std::vector<Mat3> tensors;
    if (state().hasFrames()) {
      tensors = frames_.tensors(*this, state(), masses, per_mass_);
      if (!data().find("inertia")->isSet() && vertex_mass_.size() == 1)
        inform("no inertia is given: that of a frame is its mass times 1 m^2 about each axis, as in SOFA");
    } else if (data().find("inertia")->isSet()) {
      throw ComponentError(fmt::format("the nodes of {} have no inertia: they are no frames", state().path()),
                           "template=\"Rigid3\", or no inertia");
    }
    std::vector<TurningInertia> turning;
    masses_ = FrameInertia::ofRows(state(), masses, tensors, turning);
    for (TurningInertia& one : turning) one.turns = turns_;
    setTurningInertias(std::move(turning));
  }

  std::vector<Index> chosenNodes() const {
    const bool by_range = data().find("localRange")->isSet() && !(range_ == std::vector<int>{-1, -1});
    const bool by_indices = data().find("indices")->isSet();
    if (by_range && by_indices) throw ComponentError("indices and localRange are both given", "one of them");
    if (by_indices) return checkedNodes(indices_, state(), "indices");
    const std::vector<Index> nodes = allNodes(state());
    if (!by_range) return nodes;
    if (range_.size() != 2 || range_[0] > range_[1])
      throw ComponentError("localRange is not a range", "two indices, the first and the last node");
    for (std::size_t i = 0; i < 2; ++i) checkNode(range_[i], i, state(), "localRange");
    return {nodes.begin() + range_[0], nodes.begin() + range_[1] + 1};
  }

  std::vector<double> vertex_mass_{1};  ///< as written
  double total_mass_ = 1, mass_ = 1;    ///< [kg]; of a node
  Mat3 per_mass_ = Mat3::Identity();    ///< inertia/mass [m^2]
  FrameInertia frames_;
  bool turns_ = true;
  FileName file_name_;
  std::vector<int> indices_, range_{-1, -1};
  std::vector<double> masses_;
  bool everywhere_ = true;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(uniform_mass) { factory.add<stroma::UniformMass>("UniformMass", "The same mass at every node"); }
