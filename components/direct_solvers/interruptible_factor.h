// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <utility>

#include "components/direct_solvers/left_work.h"
#include "framework/algebra/direct_solver.h"

namespace stroma {

/// A factorisation that a library makes in one call, which a stop leaves to end by itself. The call then takes what it
/// works on with it, and the next one begins with an analysis.
template <class Factor>
class InterruptibleFactor final : public Factorisation {
 public:
  using Make = std::function<std::unique_ptr<Factor>()>;
  explicit InterruptibleFactor(Make make) : make_(std::move(make)) {}

  bool analyse(const BlockMatrix& matrix, StopToken stop) override {
    inner_ = make_();
    return inner_->analyse(matrix, stop);
  }
  void load(const BlockMatrix& matrix) override {
    if (!inner_) analyse(matrix, {});
    rows_ = matrix.rows();
    inner_->load(matrix);
  }
  SolveStop factor(Index& row, StopToken stop) override {
    constexpr Index few_rows = 500;  // factored in less time than anybody waits
    if (rows_ < few_rows || !stop.isWatched()) return inner_->factor(row, stop);
    struct Result {
      SolveStop stop = SolveStop::stopped;
      Index row = -1;
    };
    const auto result = std::make_shared<Result>();
    const void* const code = *reinterpret_cast<const void* const*>(inner_.get());  // its table of virtual functions
    if (!runOrLeave([inner = inner_, result] { result->stop = inner->factor(result->row, {}); }, code, stop)) {
      inner_.reset();
      return SolveStop::stopped;
    }
    row = result->row;
    return result->stop;
  }
  void apply(ConstRows b, Rows x) override { inner_->apply(b, x); }
  void applyAll(std::span<const ConstRows> b, std::span<const Rows> x) override { inner_->applyAll(b, x); }
  Cost cost() const override { return inner_->cost(); }
  const Factor& inner() const { return *inner_; }

 private:
  Make make_;
  std::shared_ptr<Factor> inner_;  ///< null after a call was left
  Index rows_ = 0;
};

}  // namespace stroma
