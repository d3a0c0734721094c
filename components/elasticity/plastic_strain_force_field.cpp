// SPDX-License-Identifier: LGPL-2.1-or-later
// PlasticStrainForceField: subtracts the stress of a plastic strain from linear tetrahedra, in addition to a force field with
// their elastic forces, such as TetrahedronFEMForceField with the same method, moduli and mesh.
//
//   eps = sym(R^T F) - I,   sigma = D (eps - eps_p),   f_a = V R D eps_p g_a  (the part of eps_p)
//   at the end of a step:   d = eps - eps_p;   if |d| > yield: eps_p += creep d;   if |eps_p| > max: eps_p is scaled to it
//
// with R the rotation of the cell by `method` (small: I; large: frames of the first edge and the plane; polar and svd: the polar
// factor of F, or with polarOf="edges" that of the edges), g_a the gradients at rest and |.| the norm of the six engineering
// strains (xx yy zz xy yz zx). The stiffness of eps_p is left out. initialStrain is eps_p at the start, one for all or one
// for each cell: also a swelling or a growth.
//
// With scaledByVolume="true" the thresholds are compared with 6 V times the strain in the axes of the cell at rest (of
// `method`), as SOFA does: what yields depends on the mesh then, and on the order of the nodes of a cell. A creep of 1 lets a
// cell yield immediately; it is per time step, not per time.
//
// With yieldsAtStart cells also yield in their initial positions, as in SOFA, which matters if these differ from the rest
// positions.
//
// The stress of the elastic force field beside it is D eps. Cell fields for exporters: elasticStress, R sigma R^T [Pa], elasticVonMises
// [Pa] and plasticStrain, eps_p (six numbers each but for the second, xx yy zz xy yz zx: the stress in the axes of the world, the
// strain in those of the rest shape and as a tensor, half the engineering shear).
//
// Source: M. Mueller, M. Gross, Interactive virtual materials, Graphics Interface 2004, section 5; names of the thresholds are SOFA's.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="100" tolerance="1e-9"/>
//   <MeshTopology position="0 0 0  1 0 0  0 1 0  0 0 1" tetrahedra="0 1 2 3"/>
//   <MechanicalObject/>
//   <DiagonalMass massDensity="100"/>
//   <FixedProjectiveConstraint indices="0 1 2"/>
//   <TetrahedronFEMForceField method="large" youngModulus="1e4" poissonRatio="0.3"/>
//   <PlasticStrainForceField method="large" youngModulus="1e4" poissonRatio="0.3" plasticYieldThreshold="0.01" plasticMaxThreshold="0.2"
//     plasticCreep="0.1" initialStrain="0.01 0 0 0.02 0 0"/>
// </Node>
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cmath>

#include "framework/mechanics/force_field.h"
#include "framework/mechanics/history.h"
#include "framework/mechanics/state_topology.h"
#include "framework/mesh/cell_kind.h"
#include "framework/scene/archive.h"
#include "framework/scene/factory.h"
#include "framework/scene/spans.h"

namespace stroma {
namespace {

using Strain = Eigen::Matrix<double, 6, 1>;

/// A rotation, or where it `may_mirror` the factor with the sign of det m.
Mat3 polarFactor(const Mat3& m, bool may_mirror) {
  const Eigen::JacobiSVD<Mat3> svd(m, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Mat3 u = svd.matrixU();
  if (!may_mirror && (u * svd.matrixV().transpose()).determinant() < 0) u.col(2) *= -1;
  return u * svd.matrixV().transpose();
}

/// Of the first edge and the plane of the first three nodes.
Mat3 frameOf(const Vec3& a, const Vec3& b, const Vec3& c) {
  Mat3 frame;
  frame.col(0) = (b - a).normalized();
  frame.col(2) = (b - a).cross(c - a).normalized();
  frame.col(1) = frame.col(2).cross(frame.col(0));
  return frame;
}

class PlasticStrainForceField final : public ForceField, public History {
 public:
  void declare(DataTable& table) override {
    ForceField::declare(table);
    topology_.declare(table, "mesh of tetrahedra");
    table.addChoice("method", method_, {"small", "large", "polar", "svd"}).help("rotation of a cell, as that of its elastic forces");
    table.addChoice("polarOf", polar_of_, {"gradient", "edges"}).help("of what polar and svd are the factor");
    table.add("youngModulus", young_modulus_).ofCells().unit("Pa").min(0, false).physical().help(
        "Young's modulus, one for all or one per cell");
    table.add("poissonRatio", poisson_ratio_).ofCells().unit("-").min(0).max(0.5, false).help(
        "Poisson's ratio, one for all or one per cell");
    table.add("firstForOthers", first_for_others_).help("cells beyond the end of a list take its first value, as in SOFA");
    table.add("plasticYieldThreshold", threshold_).help("elastic strain beyond which a cell creeps").unit("-").min(0);
    table.add("plasticMaxThreshold", most_).help("largest plastic strain; 0: none, it stays at the start's").unit("-").min(0);
    table.add("plasticCreep", creep_).help("share of the elastic strain that becomes plastic per step").unit("-").min(0).max(1);
    table.add("initialStrain", initial_).ofCells(6).unit("-").help(
        "xx yy zz xy yz zx (engineering) at the start, one for all or one per cell");
    table.add("yieldsAtStart", yields_at_start_).help("cells yield before the first step too, from the shape that they start in");
    table.add("scaledByVolume", scaled_).help("thresholds are of 6 V times the strain in a cell's own axes, as SOFA's");
  }

  void init() override {
    ForceField::init();
    const Mesh& mesh = topology_.meshWith(cell_kinds::tetrahedron, *this, state());
    checkCount(young_modulus_.size(), mesh.tetrahedra.size(), "youngModulus");
    checkCount(poisson_ratio_.size(), mesh.tetrahedra.size(), "poissonRatio");
    if (!initial_.empty() && initial_.size() != 6 && initial_.size() != 6 * mesh.tetrahedra.size())
      throw ComponentError(fmt::format("initialStrain has {} numbers", initial_.size()), "6, or 6 for each tetrahedron");
    cells_.clear();
    for (std::size_t c = 0; c < mesh.tetrahedra.size(); ++c) addCell(mesh.tetrahedra[c], c);
    reset();
    inform("stresses of the elastic force field have the plastic strain in them: elasticStress and elasticVonMises of " + path() +
           " have not");
  }

  void reset() override {
    has_stepped_ = false;
    plastic_.assign(6 * cells_.size(), 0);
    for (std::size_t k = 0; k < plastic_.size() && !initial_.empty(); ++k) plastic_[k] = initial_[k % initial_.size()];
  }
  void serialize(Archive& archive) override {
    archive.value("has_stepped", has_stepped_);
    archive.list("plastic_strain", plastic_);
  }
  const std::vector<double>& history() const override { return plastic_; }

  ForceTraits traits() const override {
    ForceTraits traits;
    traits.symmetric = true;
    traits.has_stiffness = false;
    return traits;
  }

  double energy(ConstRows x) const override {
    double sum = 0;
    for (std::size_t c = 0; c < cells_.size(); ++c) {
      const Mat3 now = strain(cells_[c], x), plastic = plasticStrain(c), stress = stressOf(cells_[c], plastic);
      sum += cells_[c].volume * (stress.cwiseProduct(plastic / 2 - now)).sum();
    }
    return sum;
  }
  void addForce(ConstRows x, ConstRows, Rows f) override {
    const Index first = state().firstRow();
    if (yields_at_start_ && !has_stepped_) {  // every time: a program may still move the nodes
      reset();
      yield(x, first);
    }
    for (std::size_t c = 0; c < cells_.size(); ++c) {
      const Cell& cell = cells_[c];
      const Mat3 force = cell.volume * rotation(cell, x, first) * stressOf(cell, plasticStrain(c));
      for (std::size_t a = 0; a < 4; ++a) f[first + cell.nodes[a]] += force * cell.gradients[a];
    }
  }
  std::vector<std::string> cellFields() const override { return {"elasticVonMises", "elasticStress", "plasticStrain"}; }
  CellFieldShape cellFieldShape(const std::string& name) const override {
    return {&cell_kinds::tetrahedron, std::size_t(name == "elasticVonMises" ? 1 : 6)};
  }
  void cellField(const std::string& name, ConstRows x, std::vector<double>& out) const override {
    const std::size_t width = cellFieldShape(name).width;
    out.resize(width * cells_.size());
    for (std::size_t c = 0; c < cells_.size(); ++c) {
      const Cell& cell = cells_[c];
      const Mat3 r = rotation(cell, x, state().firstRow()), plastic = plasticStrain(c);
      const Mat3 m = name == "plasticStrain" ? plastic : Mat3(r * stressOf(cell, strain(cell, x) - plastic) * r.transpose());
      const double values[] = {m(0, 0), m(1, 1), m(2, 2), m(0, 1), m(1, 2), m(2, 0)};
      if (width == 1)
        out[c] = std::sqrt(1.5) * (m - m.trace() / 3 * Mat3::Identity()).norm();
      else
        std::copy(values, values + 6, out.data() + 6 * c);
    }
  }
  // K = 0
  void addStiffnessProduct(ConstRows, double, Rows) const override {}
  void addPattern(BlockPattern&) const override {}
  void addStiffness(double, BlockMatrix&) const override {}
  void addStiffnessDiagonal(double, std::vector<double>&) const override {}

  void stepEnded(double) override {
    has_stepped_ = true;
    const Span span("remember", this);
    yield(state().x(), 0);
  }

 private:
  void yield(ConstRows x, Index first) {
    if (most_ == 0) return;
    for (std::size_t c = 0; c < cells_.size(); ++c) {
      Strain elastic = engineering(strain(cells_[c], x, first)), plastic = Eigen::Map<const Strain>(plastic_.data() + 6 * c);
      elastic -= plastic;
      if (size(elastic, cells_[c]) > threshold_) plastic += creep_ * elastic;
      if (const double now = size(plastic, cells_[c]); now > most_) plastic *= most_ / now;
      Eigen::Map<Strain>(plastic_.data() + 6 * c) = plastic;
    }
  }

  struct Cell {
    Tetrahedron nodes;
    std::array<Vec3, 4> gradients;  ///< at rest [1/m]
    double volume, lambda, mu;
    Mat3 frame, polar;  ///< at rest
  };

  void checkCount(std::size_t given, std::size_t cells, const char* name) const {
    if (given != 1 && given != cells && (given == 0 || !first_for_others_))
      throw ComponentError(fmt::format("{} has {} values for {} tetrahedra", name, given, cells), "one, or one for each");
  }
  void addCell(const Tetrahedron& nodes, std::size_t c) {
    const auto rest = [&](std::size_t a) -> const Vec3& { return state().rest_position[std::size_t(nodes[a])]; };
    Mat3 edges;
    for (int k = 0; k < 3; ++k) edges.col(k) = rest(std::size_t(k) + 1) - rest(0);
    if (edges.determinant() == 0) throw ComponentError(fmt::format("tetrahedron {} is flat at rest", c), "cells with a volume");
    Cell cell;
    cell.nodes = nodes;
    const Mat3 inverse = edges.inverse();
    for (int k = 0; k < 3; ++k) cell.gradients[std::size_t(k) + 1] = inverse.row(k).transpose();
    cell.gradients[0] = -cell.gradients[1] - cell.gradients[2] - cell.gradients[3];
    cell.volume = std::abs(edges.determinant()) / 6;
    const double young = young_modulus_[c < young_modulus_.size() ? c : 0];
    const double nu = poisson_ratio_[c < poisson_ratio_.size() ? c : 0];
    cell.lambda = young * nu / ((1 + nu) * (1 - 2 * nu)), cell.mu = young / (2 * (1 + nu));
    cell.frame = frameOf(rest(0), rest(1), rest(2));
    cell.polar = polarFactor(edges, true);
    cells_.push_back(cell);
  }

  /// `first`: the row of the state in x.
  Mat3 gradient(const Cell& cell, ConstRows x, Index first) const {
    Mat3 f = Mat3::Zero();
    for (std::size_t a = 0; a < 4; ++a) f += Vec3(x[first + cell.nodes[a]]) * cell.gradients[a].transpose();
    return f;
  }
  Mat3 rotation(const Cell& cell, ConstRows x, Index first) const {
    const auto at = [&](std::size_t a) { return Vec3(x[first + cell.nodes[a]]); };
    if (method_ == Method::small) return Mat3::Identity();
    if (method_ == Method::large) return frameOf(at(0), at(1), at(2)) * cell.frame.transpose();
    if (polar_of_ == PolarOf::gradient) return polarFactor(gradient(cell, x, first), false);
    Mat3 edges;
    for (int k = 0; k < 3; ++k) edges.col(k) = at(std::size_t(k) + 1) - at(0);
    Mat3 inverse;  // of the edges at rest
    for (int k = 0; k < 3; ++k) inverse.row(k) = cell.gradients[std::size_t(k) + 1].transpose();
    if (method_ == Method::svd && (inverse * edges).determinant() < 1e-6)  // as the elastic forces
      return cell.polar * polarFactor(inverse * edges, false) * cell.polar.transpose();
    return polarFactor(edges, true) * cell.polar.transpose();
  }
  Mat3 strain(const Cell& cell, ConstRows x, Index first) const {
    const Mat3 stretch = rotation(cell, x, first).transpose() * gradient(cell, x, first);
    return (stretch + stretch.transpose()) / 2 - Mat3::Identity();
  }
  Mat3 strain(const Cell& cell, ConstRows x) const { return strain(cell, x, state().firstRow()); }
  Mat3 plasticStrain(std::size_t c) const { return tensor(plastic_.data() + 6 * c); }
  static Strain engineering(const Mat3& m) {
    Strain out;
    out << m(0, 0), m(1, 1), m(2, 2), 2 * m(0, 1), 2 * m(1, 2), 2 * m(2, 0);
    return out;
  }
  /// What the thresholds are compared with: the norm of engineering strains depends on the axes.
  double size(const Strain& strain, const Cell& cell) const {
    if (!scaled_) return strain.norm();
    const Mat3 axes = method_ == Method::large                                  ? cell.frame
                      : method_ != Method::small && polar_of_ == PolarOf::edges ? cell.polar
                                                                                : Mat3(Mat3::Identity());
    return 6 * cell.volume * engineering(axes.transpose() * tensor(strain.data()) * axes).norm();
  }
  static Mat3 tensor(const double* p) {
    Mat3 m;
    m << p[0], p[3] / 2, p[5] / 2, p[3] / 2, p[1], p[4] / 2, p[5] / 2, p[4] / 2, p[2];
    return m;
  }
  static Mat3 stressOf(const Cell& cell, const Mat3& strain) {
    return cell.lambda * strain.trace() * Mat3::Identity() + 2 * cell.mu * strain;
  }

  TopologyLink topology_;
  enum class Method : int { small, large, polar, svd } method_ = Method::large;
  enum class PolarOf : int { gradient, edges } polar_of_ = PolarOf::gradient;
  std::vector<double> young_modulus_{5000}, poisson_ratio_{0.45}, initial_;
  double threshold_ = 1e-4, most_ = 0, creep_ = 0.9;
  bool scaled_ = false, first_for_others_ = false, yields_at_start_ = false;
  bool has_stepped_ = false;  ///< a step has ended
  std::vector<Cell> cells_;
  std::vector<double> plastic_;  ///< eps_p, six engineering strains of each cell
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(plastic_strain_force_field) {
  factory.add<stroma::PlasticStrainForceField>("PlasticStrainForceField", "what a plastic strain takes off the stress of tetrahedra");
}
