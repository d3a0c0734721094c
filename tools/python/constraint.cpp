// SPDX-License-Identifier: LGPL-2.1-or-later
// A projective constraint that a Python object plays: it holds directions of nodes, and moves what it holds. Its methods:
//
//   held(t) -> (nodes (m,), projectors (m, 3, 3)): changes of the velocity of a node are limited to the image of its projector P
//   motion(t) -> (positions (m, 3) [m], velocities (m, 3) [m/s]) of these nodes at time t, where it moves them:
//                x = P x + (I - P) position, and v likewise
//
// A constraint that is `constant` is asked for its projectors once. An exception in a method comes out of Simulation.step().
#include <fmt/format.h>

#include "framework/mechanics/projective_constraint.h"
#include "framework/scene/factory.h"
#include "tools/python/played.h"

namespace stroma::python {
namespace {

class PythonConstraint final : public ProjectiveConstraint {
 public:
  ~PythonConstraint() override { letGo(object_); }
  void declare(DataTable& table) override {
    ProjectiveConstraint::declare(table);
    table.add("played", number_).help("number of the Python object that holds the nodes").unit("-").min(1).required();
  }
  void init() override {
    ProjectiveConstraint::init();
    const py::gil_scoped_acquire lock;
    object_ = playedObject(number_);
    moves_ = says(object_, "has_motion");
    is_constant_ = says(object_, "constant");
  }
  bool isConstant() const override { return is_constant_; }
  bool prescribesMotion() const override { return moves_; }
  void addProjectors(double t, std::vector<NodeProjector>& out) const override {
    bringTo(t);
    out.insert(out.end(), held_.begin(), held_.end());
  }
  void prescribe(double t, Rows x, Rows v) const override {
    bringTo(t);
    const py::gil_scoped_acquire lock;
    const py::tuple given = object_.attr("motion")(t);
    const Array positions(given[0]), velocities(given[1]);
    for (const Array& each : {positions, velocities})
      if (each.ndim() != 2 || each.shape(0) != py::ssize_t(held_.size()) || each.shape(1) != 3)
        throw py::value_error(fmt::format("the motion of {} is no two arrays of shape ({}, 3)", path(), held_.size()));
    for (std::size_t i = 0; i < held_.size(); ++i) {
      const Index row = held_[i].row;
      const Mat3 held = Mat3::Identity() - held_[i].projector;
      x[row] += held * (Vec3(positions.data() + 3 * i) - x[row]);
      v[row] += held * (Vec3(velocities.data() + 3 * i) - v[row]);
    }
  }

 private:
  /// What is held at time t.
  void bringTo(double t) const {
    if (is_asked_ && (is_constant_ || t == t_)) return;
    const py::gil_scoped_acquire lock;
    const py::tuple given = object_.attr("held")(t);
    const Indices nodes(given[0]);
    const Array projectors(given[1]);
    if (nodes.ndim() != 1 || projectors.ndim() != 3 || projectors.shape(0) != nodes.size() || projectors.shape(1) != 3 ||
        projectors.shape(2) != 3)
      throw py::value_error(path() + ": what is held is nodes (m,) and projectors (m, 3, 3)");
    std::vector<NodeProjector> held;
    for (py::ssize_t i = 0; i < nodes.size(); ++i) {
      const Index node = nodes.data()[i];
      if (node < 0 || node >= state().size())
        throw py::index_error(fmt::format("{} holds node {}, and the state has {}", path(), node, state().size()));
      const Mat3 P = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(projectors.data() + 9 * i);
      if (!((P - P.transpose()).cwiseAbs().maxCoeff() < 1e-9 && (P * P - P).cwiseAbs().maxCoeff() < 1e-9))
        throw py::value_error(fmt::format("the projector of node {} in {} is none: P = P^T = P P", node, path()));
      held.push_back({state().firstRow() + node, P});
    }
    held_.swap(held);
    t_ = t, is_asked_ = true;
  }

  int number_ = 0;
  py::object object_;
  bool moves_ = false, is_constant_ = true;
  mutable bool is_asked_ = false;
  mutable double t_ = 0;  ///< of what is held
  mutable std::vector<NodeProjector> held_;
};

}  // namespace

void registerPlayedConstraint(Factory& factory) {
  factory.add<PythonConstraint>("PythonConstraint", "a constraint that a Python object plays");
}

}  // namespace stroma::python
