// SPDX-License-Identifier: LGPL-2.1-or-later
// A force field that a Python object plays: slow, and as simple as NumPy. The object is found by the number that the
// attribute `played` holds (stroma/played.py). Its methods get arrays of their own, (n, 3), of the nodes of the state; of frames
// (n, 7) positions, (n, 6) velocities and forces:
//
//   force(x, v, t) -> (n, 3) [N]       energy(x) -> J, where there is one
//   stiffness(x, v, t) -> dF/dx as (rows, columns, blocks), blocks (m, 3, 3), of the rows of the state; none: K = 0
//
// A node is a row, a frame two: its centre and its turn.
//
// An exception in a method ends the step, which is not taken, and comes out of Simulation.step() with its traceback.
#include <fmt/format.h>

#include "framework/mechanics/force_field.h"
#include "framework/mechanics/frames.h"
#include "framework/scene/factory.h"
#include "tools/python/played.h"

namespace stroma::python {
namespace {

class PythonForceField final : public ForceField {
 public:
  ~PythonForceField() override { letGo(object_, x_, v_); }
  void declare(DataTable& table) override {
    ForceField::declare(table);
    table.add("played", number_).help("number of the Python object that computes the force").unit("-").min(1).required();
  }
  void init() override {
    ForceField::init();
    const py::gil_scoped_acquire lock;
    object_ = playedObject(number_);
    traits_.has_stiffness = says(object_, "has_stiffness");
    traits_.linear = says(object_, "linear");
    traits_.symmetric = says(object_, "symmetric") || !traits_.has_stiffness;
    traits_.conservative = says(object_, "has_energy");
    traits_.exact_tangent = says(object_, "exact_tangent");
    traits_.time_dependent = says(object_, "time_dependent");
    traits_.decided_outside = true;
    has_energy_ = says(object_, "has_energy");
  }
  ForceTraits traits() const override { return traits_; }
  void setTime(double t) override { t_ = t; }

  double energy(ConstRows x) const override {
    if (!has_energy_) return 0;
    const py::gil_scoped_acquire lock;
    return object_.attr("energy")(ownRows(x, true)).cast<double>();
  }
  void addForce(ConstRows x, ConstRows v, Rows f) override {
    const py::gil_scoped_acquire lock;
    x_ = ownRows(x, true), v_ = ownRows(v, false);
    is_fresh_ = false;
    putNumbers(state(), Array(object_.attr("force")(x_, v_, t_)), false, state().segment(f), true, "the force of " + path());
    if (!rows_.empty()) bringUp();  // its blocks may be others: they may change here only
  }
  void addStiffnessProduct(ConstRows dx, double factor, Rows df) const override {
    if (!traits_.has_stiffness) return;
    bringUp();
    for (std::size_t i = 0; i < rows_.size(); ++i) df[rows_[i]] += factor * (blocks_[i] * dx[columns_[i]]);
  }
  void addPattern(BlockPattern& pattern) const override {
    if (!traits_.has_stiffness) return;
    bringUp();
    for (std::size_t i = 0; i < rows_.size(); ++i) pattern.addBlock(rows_[i], columns_[i]), pattern.addBlock(columns_[i], rows_[i]);
  }
  long patternRevision() const override { return revision_; }
  void prepareAssembly(const BlockMatrix& matrix) override {
    slots_.clear();
    for (std::size_t i = 0; i < rows_.size(); ++i) slots_.push_back(matrix.slot(rows_[i], columns_[i]));
  }
  void addStiffness(double factor, BlockMatrix& matrix) const override {
    if (!traits_.has_stiffness) return;
    bringUp();
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      const Index slot = i < slots_.size() ? slots_[i] : -1;
      if (slot < 0) throw std::runtime_error(path() + ": its stiffness couples other nodes than before");
      matrix.add(slot, factor * blocks_[i]);
    }
  }
  void addStiffnessDiagonal(double factor, std::vector<double>& blocks) const override {
    if (!traits_.has_stiffness) return;
    bringUp();
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      if (rows_[i] != columns_[i]) continue;
      for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c) blocks[std::size_t(rows_[i]) * 9 + std::size_t(3 * r + c)] += factor * blocks_[i](r, c);
    }
  }

 protected:
  bool takesAllRows() const override { return true; }

 private:
  Array ownRows(ConstRows all, bool places) const { return numbersOf(state(), state().segment(all), places); }
  /// The stiffness at the x of the last force, asked for once.
  void bringUp() const {
    if (is_fresh_) return;
    const py::gil_scoped_acquire lock;
    if (!x_) {  // before the first force: of the pattern
      Vector start(state().size()), still(state().size());
      for (Index i = 0; i < state().size(); ++i) placeRow(state().kindOf(i), state().position[std::size_t(i)], start, i);
      x_ = numbersOf(state(), start.rows(), true), v_ = numbersOf(state(), still.rows(), false);
    }
    const py::tuple given = object_.attr("stiffness")(x_, v_, t_);
    const Indices rows(given[0]), columns(given[1]);
    const Array blocks(given[2]);
    if (blocks.ndim() != 3 || blocks.shape(0) != rows.size() || rows.size() != columns.size() || blocks.shape(1) != 3 ||
        blocks.shape(2) != 3)
      throw py::value_error(path() + ": a stiffness is rows (m,), columns (m,) and blocks (m, 3, 3)");
    std::vector<Index> new_rows, new_columns;
    blocks_.clear();
    for (py::ssize_t i = 0; i < rows.size(); ++i) {
      for (const Index node : {rows.data()[i], columns.data()[i]})
        if (node < 0 || node >= state().size())
          throw py::index_error(fmt::format("the stiffness of {} has row {}, and the state has {}", path(), node, state().size()));
      new_rows.push_back(state().firstRow() + rows.data()[i]);
      new_columns.push_back(state().firstRow() + columns.data()[i]);
      blocks_.push_back(Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(blocks.data() + 9 * i));
    }
    if (new_rows != rows_ || new_columns != columns_) ++revision_;
    rows_.swap(new_rows), columns_.swap(new_columns);
    is_fresh_ = true;
  }

  int number_ = 0;
  py::object object_;
  ForceTraits traits_;
  bool has_energy_ = false;
  double t_ = 0;
  mutable py::object x_, v_;  ///< of the last force
  mutable bool is_fresh_ = false;
  mutable std::vector<Index> rows_, columns_;  ///< of the system, of the last stiffness
  mutable std::vector<Mat3> blocks_;
  mutable long revision_ = 0;
  std::vector<Index> slots_;
};

}  // namespace

void registerPlayed(Factory& factory) {
  factory.add<PythonForceField>("PythonForceField", "a force that a Python object computes");
  registerPlayedConstraint(factory);
  registerPlayedMapping(factory);
}

}  // namespace stroma::python
