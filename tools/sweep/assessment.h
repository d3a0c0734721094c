// SPDX-License-Identifier: LGPL-2.1-or-later
// From runs to errors: the reference, how well it is known, and the distance of each run from it.
#pragma once
#include <memory>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "tools/sweep/configuration.h"
#include "tools/sweep/reference.h"
#include "tools/sweep/refinement.h"
#include "tools/sweep/richardson.h"
#include "tools/sweep/run_folder.h"

namespace stroma::sweep {

/// A configuration with all that is known of it: a row of the table.
struct Entry {
  Configuration configuration;
  Runs runs;
  std::size_t nodes = 0, cells = 0;
  double spacing = 0, dt = 0;   ///< of its mesh [m]; [s]
  std::optional<double> error;  ///< relative, see Assessment
  std::vector<double> value;    ///< what the error is of, where that is a quantity: a number, a vector or a tensor
  bool is_reference = false;
  bool on_front = false;
  std::size_t outside = 0;  ///< points of comparison outside of its mesh
  double farthest = 0;      ///< of them [m]
};

/// What the runs along one axis, the others at their finest, show about the remaining error.
struct AxisEstimate {
  std::size_t axis = 0;
  std::optional<double> order;  ///< fitted
  double uncertainty = 0;       ///< that this axis leaves to the reference, as the errors
  double expected = 0;          ///< the same without a margin of safety
  std::string how;              ///< half a sentence
};

/// How much of the reference's error the uncertainty has in it.
enum class Knowledge { whole, in_part, none };

struct Assessment {
  std::string reference;                   ///< half a sentence: what the errors are measured against
  double uncertainty = 0;                  ///< of the reference, and so of every error
  Knowledge knowledge = Knowledge::whole;  ///< in part: the uncertainty is at least this; none: there is no number
  double expected = 0;                     ///< the reference's own error as it is estimated, without a margin of safety
  bool is_relative = true;                 ///< errors are shares of the reference's norm; else they have its unit
  std::string length_unit, time_unit;      ///< of the scene; empty: unknown
  std::vector<AxisEstimate> axes;
  std::vector<std::string> notes;

  bool isUncertain() const { return uncertainty > 0 || knowledge != Knowledge::whole; }
};

class Assessor {
 public:
  /// Throws std::invalid_argument when the reference cannot be what was asked for.
  Assessor(const SweepRequest& request, const std::vector<Axis>& axes);
  const ErrorMeasure& measure() const { return measure_; }
  bool needsRuns() const { return !given_; }
  /// Fills in the errors and the front.
  Assessment assess(std::vector<Entry>& entries);

 private:
  struct Sample {
    Values values;
    std::size_t nodes = 0, cells = 0, outside = 0;
    std::vector<double> told;  ///< a quantity, as the run tells it; empty for fields
    double spacing = 0, dt = 0, time = 0, farthest = 0;
    Mat3 spacings = Mat3::Zero();  ///< in all directions, see spacingTensor()
    std::string length_unit, time_unit;
    std::optional<double> own_error;  ///< from a formula, at the Gauss points of the run's own mesh
  };
  /// Runs along an axis from fine to coarse.
  struct Line {
    std::vector<double> sizes;
    std::vector<const Values*> values;
    std::vector<Mat3> spacings;
    std::vector<std::string> names;  ///< of the axis' values
  };
  Entry* referenceRun(std::vector<Entry>& entries) const;
  const Sample& sampleOf(const Entry& entry);
  Line lineAlong(std::size_t axis, const std::vector<Entry>& entries, const Entry& finest, const Entry& reference);
  Triple tripleOf(const Line& line, std::size_t first) const;
  void tellRefinement(std::size_t axis, const Line& line, Assessment& assessment) const;
  AxisEstimate estimate(std::size_t axis, const Line& line, Values& limit) const;
  void settleReference(std::vector<Entry>& entries, Entry& run, Assessment& assessment);
  bool isOfReferenceTime(const Sample& sample) const;
  /// Of a run. Throws std::runtime_error when it cannot be compared.
  double errorOf(const Sample& sample, double scale) const;
  /// The reference that this run is of or tells the points for.
  void settle(std::vector<Entry>& entries, Entry& run, Assessment& assessment);
  void distances(std::vector<Entry>& entries, Assessment& assessment);
  /// A formula has a value everywhere: no mesh but the run's own is needed.
  bool comparesOnOwnMesh() const { return given_ && measure_.isField() && given_->points().size() == 0; }

  const SweepRequest& request_;
  const std::vector<Axis>& axes_;
  ErrorMeasure measure_;
  std::unique_ptr<GivenReference> given_;
  CommonPoints points_;
  std::string points_of_;  ///< the run that gave them
  Values reference_;
  double reference_time_ = 0;                        ///< [s]
  std::unordered_map<std::string, Sample> samples_;  ///< by keys
};

/// Marks the entries that no other one beats in time to the end and error. Errors below `expected`, the reference's own,
/// count as it: nobody can tell them apart.
void markFront(std::vector<Entry>& entries, double expected);

/// "known to 3 %", with what it does not hold; `number` is the uncertainty in words.
std::string knownTo(const Assessment& assessment, const std::string& number);

/// The finest good entry of the grid, or null.
const Entry* finestOf(const std::vector<Axis>& axes, const std::vector<Entry>& entries);

}  // namespace stroma::sweep
