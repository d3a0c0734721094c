// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/sweep/assessment.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace stroma::sweep {
namespace {

/// How far up its axis a value is: 0 the coarsest, 1 the finest.
double fineness(const Axis& axis, std::size_t value) {
  if (axis.size() < 2) return 1;
  double coarser = 0;
  for (std::size_t k = 0; k < axis.size(); ++k) coarser += k != value && axis.isFiner(value, k);
  return coarser / double(axis.size() - 1);
}

Values scaledDifference(double factor, const Values& a, const Values& b) {
  Values result(a.size());
  for (std::size_t i = 0; i < a.size(); ++i) result[i] = factor * (a[i] - b[i]);
  return result;
}

Values sum(const Values& a, const Values& b) {
  return scaledDifference(1, a, scaledDifference(-1, b, Values(b.size(), Vec3::Zero())));
}

/// A direction that is refined less than this bounds nothing.
constexpr double least_bounding_refinement = 1.1;

/// Numbers that nothing orders, as Young's moduli: switches and threads are none.
bool isQuantity(const Axis& axis) {
  if (axis.isOrdered() || axis.attributes.front() == "threads") return false;
  const auto isNumber = [](const std::vector<std::string>& values) {
    const std::string& text = values.front();
    double number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    // a unit may follow, with a blank or without; a file's name begins otherwise, or has a point after its number
    const bool is_file = text.find('.', std::size_t(end - text.data())) != std::string::npos;
    return text != "0" && text != "1" && error == std::errc() && !is_file;
  };
  return std::ranges::all_of(axis.values, isNumber);
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
  if (!measure_.isField()) sample.told = end.quantity;
  if (!measure_.isField() && !measure_.asksRun())
    sample.told.assign(sample.values[0].data(), sample.values[0].data() + (measure_.kind == ErrorMeasure::Kind::energy ? 1 : 3));
  sample.nodes = end.nodes(), sample.cells = end.cells(), sample.spacing = end.spacing();
  sample.spacings = spacingTensor(end);
  sample.dt = end.dt, sample.time = end.time;
  sample.length_unit = end.length_unit, sample.time_unit = end.time_unit;
  if (measure_.isField()) sample.outside = points.outside(), sample.farthest = points.farthestOutside();
  return samples_[entry.configuration.key] = std::move(sample);
}

Assessor::Line Assessor::lineAlong(std::size_t axis, const std::vector<Entry>& entries, const Entry& finest,
                                   const Entry& reference) {
  struct Point {
    double size;
    const Sample* sample;
    std::string name;
  };
  std::vector<Point> points;
  for (const Entry& entry : entries) {
    if (!entry.runs.isGood() || entry.configuration.isExtraReference()) continue;
    bool on_line = true;
    for (std::size_t a = 0; a < axes_.size(); ++a)
      on_line = on_line && (a == axis || entry.configuration.choice[a] == finest.configuration.choice[a]);
    if (!on_line) continue;
    const std::size_t value = entry.configuration.choice[axis];
    const double size = axes_[axis].sizes[value];
    // more iterations are finer: their inverse is the size
    const bool is_inverse = axes_[axis].kind == AxisKind::iterations;
    try {
      const Sample& sample = sampleOf(entry);
      if (isOfReferenceTime(sample))
        points.push_back({is_inverse ? 1 / size : size, &sample, axes_[axis].valueText(value)});
    } catch (const std::exception&) {  // distances() says why
    }
  }
  std::ranges::sort(points, {}, &Point::size);
  if (reference.configuration.isExtraReference() && axes_[axis].hasOrder()) {
    const Sample& extra = sampleOf(reference);
    const Vec3& direction = axes_[axis].direction;
    const double size = axes_[axis].kind != AxisKind::mesh ? extra.dt
                        : direction.isZero()               ? extra.spacing
                                                           : spacingAlong(extra.spacings, direction);
    if (!points.empty() && size < 0.999 * points.front().size)
      points.insert(points.begin(), {size, &extra, "the run of --reference-set"});
  }
  Line line;
  for (const Point& point : points) {
    line.sizes.push_back(point.size), line.values.push_back(&point.sample->values);
    line.spacings.push_back(point.sample->spacings), line.names.push_back(point.name);
  }
  return line;
}

Triple Assessor::tripleOf(const Line& line, std::size_t first) const {
  const auto& u = line.values;
  const auto apart = [&](std::size_t a, std::size_t b) { return measure_.distance(*u[a], *u[b], points_); };
  const auto& s = line.sizes;
  Triple triple{s[first],
                s[first + 1],
                s[first + 2],
                apart(first, first + 1),
                apart(first + 1, first + 2),
                apart(first, first + 2),
                0};
  triple.cosine = measure_.cosine(scaledDifference(1, *u[first], *u[first + 1]),
                                  scaledDifference(1, *u[first + 1], *u[first + 2]), points_);
  const Refinement whole = refinementBetween(line.spacings[first], line.spacings[first + 2]);
  for (std::size_t k = first; k < first + 2; ++k) {
    const Refinement step = refinementBetween(line.spacings[k], line.spacings[k + 1]);
    if (step.isEven(whole.fixed())) continue;
    triple.least_refinement =
        refinementBetween(line.spacings[first], line.spacings[first + 1]).ratio[std::size_t(whole.fixed())];
  }
  return triple;
}

/// `limit` gets what is to be added to the finest values.
AxisEstimate Assessor::estimate(std::size_t axis, const Line& line, Values& limit) const {
  AxisEstimate result;
  result.axis = axis;
  const auto& s = line.sizes;
  const auto& u = line.values;
  if (s.size() < 2) return result;
  const double next = measure_.distance(*u[0], *u[1], points_);
  result.uncertainty = result.expected = next, result.how = "difference to the next finest";
  if (!axes_[axis].hasOrder()) return result;
  const bool extrapolates = request_.reference == "extrapolated";
  const auto limitOf = [&](const Extrapolation& from, std::size_t first) {
    return sum(*u[first], scaledDifference(from.factor, *u[first], *u[first + 1]));
  };
  Extrapolation found = s.size() == 2 ? ofTwo(s[0], s[1], next) : extrapolate(tripleOf(line, 0));
  if (s.size() > 3) {
    const Extrapolation without_finest = extrapolate(tripleOf(line, 1));
    found = confirmed(found, without_finest, measure_.distance(limitOf(found, 0), limitOf(without_finest, 1), points_));
  }
  const Margin& margin = extrapolates ? found.of_limit : found.of_finest;
  result.order = found.order, result.uncertainty = margin.size, result.how = margin.how;
  result.expected = found.correction;
  if (!extrapolates || !found.hasLimit()) return result;
  limit = scaledDifference(found.factor, *u[0], *u[1]);
  result.expected = margin.size / 2;  // one standard deviation of two
  return result;
}

/// What the refinement of the three finest meshes leaves open.
void Assessor::tellRefinement(std::size_t axis, const Line& line, Assessment& assessment) const {
  const std::size_t last = std::min<std::size_t>(line.sizes.size(), 3) - 1;
  const Refinement whole = refinementBetween(line.spacings[0], line.spacings[last]);
  const std::string label = axes_[axis].label();
  std::string directions;
  for (int i = 0; i < whole.fixed(); ++i)
    directions += (i ? " and " : "") + directionText(whole.direction[std::size_t(i)]);
  if (!directions.empty()) {
    assessment.knowledge = Knowledge::in_part;
    assessment.notes.push_back(fmt::format(
        "the meshes of {} are not refined along {}: what the spacing there leaves is not in the uncertainty", label,
        directions));
  }
  for (std::size_t k = 0; k < last; ++k) {
    const Refinement step = refinementBetween(line.spacings[k], line.spacings[k + 1]);
    if (step.isEven(whole.fixed())) continue;
    const auto least = std::size_t(whole.fixed());
    assessment.notes.push_back(fmt::format(
        "{} is refined unevenly: from {} to {} the spacing falls by {:.3g} along {} and by {:.3g} along {}; the order cannot be "
        "determined (expected meshes refined equally in all directions)",
        label, line.names[k + 1], line.names[k], step.ratio[2], directionText(step.direction[2]), step.ratio[least],
        directionText(step.direction[least])));
    if (k == 0 && step.ratio[least] < least_bounding_refinement) assessment.knowledge = Knowledge::in_part;
  }
}

void Assessor::settleReference(std::vector<Entry>& entries, Entry& run, Assessment& assessment) {
  reference_ = sampleOf(run).values;
  const Entry* finest = finestOf(axes_, entries);
  bool corrected = false;
  std::string untold;
  for (std::size_t a = 0; finest && a < axes_.size(); ++a) {
    if (!axes_[a].isOrdered()) continue;
    Values limit;
    const Line line = lineAlong(a, entries, *finest, run);
    AxisEstimate estimated = estimate(a, line, limit);
    if (estimated.how.empty()) {
      untold += (untold.empty() ? "" : " and ") + axes_[a].label();
      continue;
    }
    if (axes_[a].kind == AxisKind::mesh) tellRefinement(a, line, assessment);
    assessment.uncertainty += estimated.uncertainty, assessment.expected += estimated.expected;
    if (request_.reference == "extrapolated" && !limit.empty()) reference_ = sum(reference_, limit), corrected = true;
    assessment.axes.push_back(std::move(estimated));
  }
  const std::string name = run.configuration.isExtraReference() ? "the run of --reference-set"
                                                                : "the finest run, " + nameOf(axes_, run.configuration);
  assessment.reference = corrected ? "the extrapolation from " + name : name;
  if (request_.reference == "extrapolated" && !corrected)
    assessment.notes.push_back(
        "nothing could be extrapolated: fewer than three results along each mesh and time step, or differences that "
        "follow no order; the reference is the finest run");
  for (const Axis& axis : axes_)
    if (std::ranges::any_of(axis.sizes, [](double size) { return std::isinf(size); }))
      assessment.notes.push_back(
          fmt::format("a value of {} was refused: how fine it would have been is not known", axis.label()));
  for (const Axis& axis : axes_)
    if (finest && fineness(axis, finest->configuration.choice[std::size_t(&axis - axes_.data())]) < 1 &&
        axis.isOrdered())
      assessment.notes.push_back(
          fmt::format("the finest value of {} has no result: the reference is the next finest", axis.label()));
  for (const Axis& axis : axes_)
    if (isQuantity(axis))
      assessment.notes.push_back(fmt::format(
          "{} orders nothing: what is called error is the difference to its last value, {}. Where it is of the physics each "
          "value has a solution of its own: a sweep of each with --set, or --reference",
          axis.label(), axis.valueText(axis.size() - 1)));
  if (assessment.axes.empty()) {
    assessment.knowledge = Knowledge::none;
    assessment.notes.push_back("no varied value shows how accurate the reference is: its uncertainty is unknown");
  } else if (!untold.empty()) {
    assessment.knowledge = Knowledge::in_part;
    assessment.notes.push_back(
        fmt::format("{} has one result only: what it leaves to the reference is not in the uncertainty", untold));
  }
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
      entry.value = sample.told;
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
  assessment.length_unit = sampleOf(run).length_unit, assessment.time_unit = sampleOf(run).time_unit;
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

std::string knownTo(const Assessment& assessment, const std::string& number) {
  if (assessment.knowledge == Knowledge::none) return "its uncertainty is unknown";
  return "known to " + number + (assessment.knowledge == Knowledge::in_part ? " at best" : "");
}

}  // namespace stroma::sweep
