// SPDX-License-Identifier: LGPL-2.1-or-later
// A mapping that a Python object plays. The object is found by the number that the attribute `played` holds. Its methods get and give
// arrays of their own, of the nodes of the two states: (n, 3) of points, (n, 7) and (n, 6) of frames, and so on (played.h).
//
//   apply(x) -> x of the child          applyJ(v) -> J v         applyJT(f) -> J^T f         all at the x of the last apply()
//   size(width of the parent, width of the child): numbers of a node, told once before all others
//   jacobian() -> J as (rows of the child, rows of the parent, blocks (m, 3, 3)), always of the same pairs of rows
//
// The force on the child keeps its direction in the tangent, and masses on it press outwards in no turn: dJ/dx is not asked for.
// An exception in a method ends the step, which is not taken, and comes out of Simulation.step() with its traceback.
#include "framework/mechanics/mapping.h"

#include "framework/scene/factory.h"
#include "framework/scene/node.h"
#include "tools/python/played.h"

namespace stroma::python {
namespace {

class PythonMapping final : public Mapping {
 public:
  ~PythonMapping() override { letGo(object_); }
  void declare(DataTable& table) override {
    table.add("played", number_).help("number of the Python object that places the nodes").unit("-").min(1).required();
    table.addLink("input", input_).help("state that is followed; the one of the parent node or above when not given");
    table.addLink("output", output_).help("state whose nodes follow; the one of this node when not given");
  }
  void init() override {
    parent_ = input_.get() ? input_.get() : node().parent() ? node().parent()->find<State>(this, true) : nullptr;
    child_ = output_.get() ? output_.get() : find<State>(false);
    if (!parent_ || !child_ || parent_ == child_)
      throw ComponentError("a mapping is from one state to another", "input=\"@path\" and output=\"@path\" of two states");
    parent_->ensureReady(), child_->ensureReady();
    const py::gil_scoped_acquire lock;
    object_ = playedObject(number_);
    object_.attr("size")(widthOf(*parent_, true), widthOf(*child_, true));
  }
  State& input() const override { return *parent_; }
  State& output() const override { return *child_; }
  bool isLinear() const override { return false; }

  void apply(Rows x) const override {
    const py::gil_scoped_acquire lock;
    const Array places(object_.attr("apply")(numbersOf(*parent_, parent_->segment(ConstRows(x)), true)));
    putNumbers(*child_, places, true, child_->segment(x), false, "what apply() of " + path() + " gives");
  }
  void applyJ(Rows v) const override {
    const py::gil_scoped_acquire lock;
    const Array moved(object_.attr("applyJ")(numbersOf(*parent_, parent_->segment(ConstRows(v)), false)));
    putNumbers(*child_, moved, false, child_->segment(v), false, "what applyJ() of " + path() + " gives");
  }
  void applyJT(Rows f) const override {
    const py::gil_scoped_acquire lock;
    const Array force(object_.attr("applyJT")(numbersOf(*child_, child_->segment(ConstRows(f)), false)));
    putNumbers(*parent_, force, false, parent_->segment(f), true, "what applyJT() of " + path() + " gives");
  }
  void addJacobian(std::vector<JacobianBlock>& out) const override {
    const py::gil_scoped_acquire lock;
    const py::tuple given = object_.attr("jacobian")();
    const Indices rows(given[0]), columns(given[1]);
    const Array blocks(given[2]);
    if (blocks.ndim() != 3 || blocks.shape(0) != rows.size() || rows.size() != columns.size() || blocks.shape(1) != 3 ||
        blocks.shape(2) != 3)
      throw py::value_error(path() + ": a Jacobian is rows (m,), columns (m,) and blocks (m, 3, 3)");
    for (py::ssize_t i = 0; i < rows.size(); ++i) {
      checkRow(rows.data()[i], *child_), checkRow(columns.data()[i], *parent_);
      out.push_back({child_->firstRow() + rows.data()[i], parent_->firstRow() + columns.data()[i],
                     Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(blocks.data() + 9 * i)});
    }
  }
  void addCurvature(ConstRows, Rows) const override {}
  void addGeometricProduct(ConstRows, ConstRows, double, Rows) const override {}
  void addGeometricPattern(BlockPattern&) const override {}
  void addGeometricStiffness(ConstRows, double, BlockMatrix&) const override {}

 private:
  void checkRow(Index row, const State& state) const {
    if (row < 0 || row >= state.size())
      throw py::index_error(fmt::format("the Jacobian of {} has row {}, and {} has {}", path(), row, state.path(), state.size()));
  }

  int number_ = 0;
  Link<State> input_{"mechanical state"}, output_{"mechanical state"};
  State *parent_ = nullptr, *child_ = nullptr;
  py::object object_;
};

}  // namespace

void registerPlayedMapping(Factory& factory) {
  factory.add<PythonMapping>("PythonMapping", "a mapping that a Python object plays");
}

}  // namespace stroma::python
