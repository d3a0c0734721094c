// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/sweep/assessment.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "tools/sweep/richardson.h"

namespace stroma::sweep {
namespace {

/// How far up its axis a value is: 0 the coarsest, 1 the finest.
double fineness(const Axis& axis, std::size_t value) {
  if (axis.size() < 2) return 1;
  double coarser = 0;
  for (std::size_t k = 0; k < axis.size(); ++k) coarser += k != value && axis.isFiner(value, k);
  return coarser / double(axis.size() - 1);
}

/// Safety of a correction that is not made. Source: Roache 1998, section 5.9.
constexpr double safety = 1.25, safety_without_order = 3;
/// Elements and integrators of the framework have no higher one: a fit above it is luck, and would flatter.
constexpr double highest_order = 2;
/// Differences that point less the same way than this are no approach to a limit.
constexpr double least_cosine = 0.5;

Values scaledDifference(double factor, const Values& a, const Values& b) {
  Values result(a.size());
  for (std::size_t i = 0; i < a.size(); ++i) result[i] = factor * (a[i] - b[i]);
  return result;
}

Values sum(const Values& a, const Values& b) {
  return scaledDifference(1, a, scaledDifference(-1, b, Values(b.size(), Vec3::Zero())));
}

void leaveOut(Entry& entry, const std::exception& problem) {
  entry.runs.outcome = "not comparable", entry.runs.failure = problem.what();
}

}  // namespace

Assessor::Assessor(const SweepRequest& request, const std::vector<Axis>& axes)
    : request_(request),
      axes_(axes),
      measure_(ErrorMeasure::parse(request.error)),
      given_(parseReference(request.reference, measure_)) {
  if (given_ && !request.reference_settings.empty())
    throw std::invalid_argument("--reference-set is for a reference that is run: --reference finest or extrapolated");
  if (request.reference != "extrapolated") return;
  const bool can = std::ranges::any_of(axes, [](const Axis& axis) { return axis.hasOrder() && axis.size() >= 3; });
  if (!can)
    throw std::invalid_argument(
        "--reference extrapolated needs three values of a mesh or of the time step (expected more values, or "
        "--reference "
        "finest)");
}

const Entry* finestOf(const std::vector<Axis>& axes, const std::vector<Entry>& entries) {
  const Entry* best = nullptr;
  double best_fineness = -1;
  for (const Entry& entry : entries) {
    if (entry.configuration.isExtraReference() || !entry.runs.isGood()) continue;
    double all = 0;
    for (std::size_t a = 0; a < axes.size(); ++a) all += fineness(axes[a], entry.configuration.choice[a]);
    if (all >= best_fineness) best = &entry, best_fineness = all;
  }
  return best;
}

Entry* Assessor::referenceRun(std::vector<Entry>& entries) const {
  for (Entry& entry : entries)
    if (entry.configuration.isExtraReference() && entry.runs.isGood()) return &entry;
  return const_cast<Entry*>(finestOf(axes_, entries));
}

const Assessor::Sample& Assessor::sampleOf(const Entry& entry) {
  const auto known = samples_.find(entry.configuration.key);
  if (known != samples_.end()) return known->second;
  const EndState end = EndState::read(endFile(entry.configuration.folder));
  Sample sample;
  const CommonPoints own = comparesOnOwnMesh() ? CommonPoints(end) : CommonPoints();
  const CommonPoints& points = comparesOnOwnMesh() ? own : points_;
  sample.values = measure_.valuesOf(end, entry.runs.repetitions.front().summary, points);
  if (comparesOnOwnMesh()) {
    const Values wanted = given_->valuesAt(own, end.time);
    const double size = measure_.norm(wanted, own);
    sample.own_error = measure_.distance(sample.values, wanted, own) / (size > 0 ? size : 1);
    sample.values.clear();
  }
  sample.nodes = end.nodes(), sample.cells = end.cells(), sample.spacing = end.spacing();
  sample.dt = end.dt, sample.time = end.time;
  if (measure_.isField()) sample.outside = points.outside(), sample.farthest = points.farthestOutside();
  return samples_[entry.configuration.key] = std::move(sample);
}

Assessor::Line Assessor::lineAlong(std::size_t axis, const std::vector<Entry>& entries, const Entry& finest,
                                   const Entry& reference) {
  std::vector<std::pair<double, const Values*>> points;
  for (const Entry& entry : entries) {
    if (!entry.runs.isGood() || entry.configuration.isExtraReference()) continue;
    bool on_line = true;
    for (std::size_t a = 0; a < axes_.size(); ++a)
      on_line = on_line && (a == axis || entry.configuration.choice[a] == finest.configuration.choice[a]);
    const double size = axes_[axis].sizes[entry.configuration.choice[axis]];
    // more iterations are finer: their inverse is the size
    const bool is_inverse = axes_[axis].kind == AxisKind::iterations;
    if (!on_line) continue;
    try {
      const Sample& sample = sampleOf(entry);
      if (isOfReferenceTime(sample)) points.emplace_back(is_inverse ? 1 / size : size, &sample.values);
    } catch (const std::exception&) {  // distances() says why
    }
  }
  std::ranges::sort(points, {}, [](const auto& point) { return point.first; });
  if (reference.configuration.isExtraReference() && axes_[axis].hasOrder()) {
    const Sample& extra = sampleOf(reference);
    const double size = axes_[axis].kind == AxisKind::mesh ? extra.spacing : extra.dt;
    if (!points.empty() && size < 0.999 * points.front().first) points.insert(points.begin(), {size, &extra.values});
  }
  Line line;
  for (const auto& [size, values] : points) line.sizes.push_back(size), line.values.push_back(values);
  return line;
}

/// `limit` gets what is to be added to the finest values.
AxisEstimate Assessor::estimate(std::size_t axis, const Line& line, Values& limit) const {
  AxisEstimate result;
  result.axis = axis;
  const auto& s = line.sizes;
  const auto& u = line.values;
  const auto apart = [&](std::size_t a, std::size_t b) { return measure_.distance(*u[a], *u[b], points_); };
  if (s.size() < 2) return result;
  const double next = apart(0, 1);
  result.uncertainty = result.expected = next, result.how = "difference to the next finest";
  if (!axes_[axis].hasOrder() || next == 0) return result;
  if (s.size() == 2) {
    result.expected = correctionFactor(s[0], s[1], 1) * next;
    result.uncertainty = safety_without_order * result.expected;
    result.how = "three times the correction to size zero by an order of 1: two values tell no order";
    return result;
  }
  const auto correctionFrom = [&](std::size_t first) -> std::optional<std::pair<double, Values>> {
    if (measure_.cosine(scaledDifference(1, *u[first], *u[first + 1]),
                        scaledDifference(1, *u[first + 1], *u[first + 2]), points_) <= least_cosine)
      return {};
    const auto order =
        fittedOrder(s[first], s[first + 1], s[first + 2], apart(first, first + 1), apart(first + 1, first + 2));
    if (!order || *order < 0.5) return {};
    const double factor = correctionFactor(s[first], s[first + 1], *order);
    return std::pair(*order, scaledDifference(factor, *u[first], *u[first + 1]));
  };
  const auto fine = correctionFrom(0);
  if (!fine) {
    result.uncertainty = safety_without_order * next;
    result.how = "three times the difference to the next finest: the differences follow no order";
    return result;
  }
  result.order = fine->first;
  limit = fine->second;
  const double correction = correctionFactor(s[0], s[1], std::min(*result.order, highest_order)) * next;
  const bool extrapolates = request_.reference == "extrapolated";
  const auto coarse = s.size() >= 4 && extrapolates ? correctionFrom(1) : std::nullopt;
  if (!extrapolates) {
    result.uncertainty = safety * correction, result.expected = correction;
    result.how = "1.25 times the correction to size zero";
  } else if (coarse) {
    result.expected = measure_.distance(sum(*u[0], limit), sum(*u[1], coarse->second), points_);
    result.uncertainty = std::max(result.expected, (safety - 1) * correction);
    result.how = "difference to the extrapolation without the finest, or a quarter of the correction to size zero";
  } else {
    result.uncertainty = result.expected = (safety - 1) * correction;
    result.how = "a quarter of the correction to size zero";
  }
  return result;
}

void Assessor::settleReference(std::vector<Entry>& entries, Entry& run, Assessment& assessment) {
  reference_ = sampleOf(run).values;
  const Entry* finest = finestOf(axes_, entries);
  bool corrected = false;
  for (std::size_t a = 0; finest && a < axes_.size(); ++a) {
    if (!axes_[a].isOrdered()) continue;
    Values limit;
    AxisEstimate estimated = estimate(a, lineAlong(a, entries, *finest, run), limit);
    if (estimated.how.empty()) continue;
    assessment.uncertainty += estimated.uncertainty, assessment.expected += estimated.expected;
    if (request_.reference == "extrapolated" && !limit.empty()) reference_ = sum(reference_, limit), corrected = true;
    assessment.axes.push_back(std::move(estimated));
  }
  const std::string name = run.configuration.isExtraReference() ? "the run of --reference-set"
                                                                : "the finest run, " + nameOf(axes_, run.configuration);
  assessment.reference = corrected ? "the extrapolation from " + name : name;
  if (request_.reference == "extrapolated" && !corrected)
    assessment.notes.push_back(
        "nothing could be extrapolated: the differences follow no order; the reference is the finest run");
  for (const Axis& axis : axes_)
    if (finest && fineness(axis, finest->configuration.choice[std::size_t(&axis - axes_.data())]) < 1 &&
        axis.isOrdered())
      assessment.notes.push_back(
          fmt::format("the finest value of {} has no result: the reference is the next finest", axis.label()));
  if (assessment.axes.empty())
    assessment.notes.push_back(
        "nothing that varies tells how well the reference is known: its uncertainty counts as zero");
  run.is_reference = !corrected;
}

bool Assessor::isOfReferenceTime(const Sample& sample) const {
  constexpr double tolerance = 1e-6;
  return std::abs(sample.time - reference_time_) <=
         tolerance * std::max(std::abs(reference_time_), std::abs(sample.time));
}

double Assessor::errorOf(const Sample& sample, double scale) const {
  if (sample.own_error) return *sample.own_error;
  if (given_ && given_->dependsOnTime())
    return measure_.distance(sample.values, given_->valuesAt(points_, sample.time), points_) / scale;
  if (!isOfReferenceTime(sample))
    throw std::runtime_error(
        fmt::format("it ends at {:g} s and the reference at {:g} s", sample.time, reference_time_));
  return measure_.distance(sample.values, reference_, points_) / scale;
}

void Assessor::distances(std::vector<Entry>& entries, Assessment& assessment) {
  const double magnitude = comparesOnOwnMesh() ? 1 : measure_.norm(reference_, points_);
  assessment.is_relative = magnitude > 0;
  const double scale = assessment.is_relative ? magnitude : 1;
  assessment.uncertainty /= scale, assessment.expected /= scale;
  for (AxisEstimate& axis : assessment.axes) axis.uncertainty /= scale, axis.expected /= scale;
  for (Entry& entry : entries) {
    if (!entry.runs.isGood()) continue;
    try {
      const Sample& sample = sampleOf(entry);
      entry.nodes = sample.nodes, entry.cells = sample.cells, entry.spacing = sample.spacing, entry.dt = sample.dt;
      entry.outside = sample.outside, entry.farthest = sample.farthest;
      entry.error = errorOf(sample, scale);
      if (entry.is_reference) entry.error = assessment.expected;
    } catch (const std::exception& problem) {
      leaveOut(entry, problem);
    }
  }
}

void Assessor::settle(std::vector<Entry>& entries, Entry& run, Assessment& assessment) {
  if (points_of_ != run.configuration.key && !(given_ && !points_of_.empty())) {
    samples_.clear();
    if (measure_.isField() && !comparesOnOwnMesh())
      points_ = given_ ? given_->points() : CommonPoints(EndState::read(endFile(run.configuration.folder)));
    points_of_ = run.configuration.key;
  }
  reference_time_ = sampleOf(run).time;
  if (!given_) return settleReference(entries, run, assessment);
  assessment.reference = given_->text();
  if (!comparesOnOwnMesh()) reference_ = given_->valuesAt(points_, reference_time_);
  reference_time_ = given_->time().value_or(reference_time_);
}

Assessment Assessor::assess(std::vector<Entry>& entries) {
  Assessment assessment;
  for (Entry& entry : entries) entry.error.reset(), entry.is_reference = entry.on_front = false;
  while (Entry* run = referenceRun(entries)) {
    try {
      assessment = {};
      settle(entries, *run, assessment);
    } catch (const std::exception& problem) {  // the next finest stands in
      leaveOut(*run, problem);
      continue;
    }
    distances(entries, assessment);
    if (request_.timed) markFront(entries, assessment.expected);
    return assessment;
  }
  assessment.reference = "none: no run has a result";
  return assessment;
}

void markFront(std::vector<Entry>& entries, double expected) {
  std::vector<Entry*> order;
  for (Entry& entry : entries)
    if (entry.error && entry.runs.isGood() && entry.runs.hasTimes() && !entry.configuration.isExtraReference())
      order.push_back(&entry);
  std::ranges::stable_sort(order, {}, [](const Entry* entry) { return entry->runs.medianOf(&Repetition::seconds); });
  double best = std::numeric_limits<double>::infinity();
  for (Entry* entry : order) {
    const double error = std::max(*entry->error, expected);
    entry->on_front = error < best;
    best = std::min(best, error);
  }
}

}  // namespace stroma::sweep
