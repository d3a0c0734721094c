// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/view/live_run.h"

#include <fmt/format.h>

#include <algorithm>

#include "framework/scene/output_file.h"
#include "tools/checks/result_doubts.h"
#include "tools/session/replay.h"
#include "tools/view/orders.h"
#include "tools/view/scene_packets.h"

namespace stroma::view {
namespace {

using nlohmann::json;

constexpr long steps_per_call = 1000;  // statistics of a call to Session::run() grow with its steps
constexpr std::size_t most_orders = 1000;
constexpr auto status_period = std::chrono::milliseconds(100);
constexpr double window_seconds = 1;

double secondsBetween(std::chrono::steady_clock::time_point from, std::chrono::steady_clock::time_point to) {
  return std::chrono::duration<double>(to - from).count();
}

/// What changes nothing, and only its page wants to know.
bool isQuestion(const json& message) { return !needsControl(message.value("do", "")); }

bool isOfHand(const json& message) {
  const std::string verb = message.value("do", "");
  return verb == "pull" || verb == "force" || verb == "push" || verb == "move";
}

}  // namespace

LiveRun::LiveRun(Session& session, const ViewRequest& request, Audience& audience)
    : session_(session),
      request_(request),
      audience_(audience),
      simulation_(session.simulation()),
      drawing_(drawingOf(simulation_)),
      hands_(simulation_, drawing_),
      values_(simulation_, drawing_),
      frames_(simulation_, drawing_),
      segments_(segmentsOf(simulation_)),
      numbers_(drawing_) {
  simulation_.computeOnDemand(true);
  session_.followMeshChanges([this](const NodesNow& now) { meshChanged(now); });
}

// ---- other threads ----

void LiveRun::stop() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
    session_.requestStop();
  }
  changed_.notify_all();
}

void LiveRun::stopIsDone() {
  const std::lock_guard lock(mutex_);
  if (!stopping_) session_.withdrawStop();
}

bool LiveRun::post(Order order) {
  {
    const std::lock_guard lock(mutex_);
    if (isOfHand(order.message)) {
      // the newest place of a hand is what counts, unless something else was asked for meanwhile
      const auto same = std::find_if(orders_.rbegin(), orders_.rend(), [&order](const Order& other) {
        return !isOfHand(other.message) || (other.client == order.client &&
                                            other.message.value("hand", json()) == order.message.value("hand", json()));
      });
      if (same != orders_.rend() && same->message["do"] == order.message["do"] && !same->message.contains("request")) {
        same->message = std::move(order.message);
        return true;
      }
    }
    // what a page that goes has left in the queue would be done by nobody's hand, or told to nobody
    if (order.message.value("do", "") == "leave")
      std::erase_if(orders_, [&order](const Order& other) {
        return other.client == order.client && (isOfHand(other.message) || isQuestion(other.message));
      });
    if (orders_.size() >= most_orders && !isOfServer(order.message)) return false;
    // a step of minutes is given up for it
    if (const std::string verb = order.message.value("do", ""); verb == "pause" || verb == "reset")
      session_.requestStop();
    orders_.push_back(std::move(order));
    ordered_ = true;
  }
  changed_.notify_all();
  return true;
}

void LiveRun::setDemand(const Demand& demand) {
  {
    const std::lock_guard lock(mutex_);
    demand_ = demand;
    can_draw_ = demand.can_draw, connected_ = demand.connected;
  }
  changed_.notify_all();
}

void LiveRun::checkWanted(const std::set<int>& fields, const std::set<std::string>& values) const {
  const std::lock_guard lock(mutex_);  // an edit may replace the drawing
  if (has_changed_meshes_) return;
  for (const int field : fields)
    if (field < 1 || field > int(drawing_.fields.size()))
      throw ComponentError(fmt::format("there is no field {}", field),
                           fmt::format("one of the {} that the scene has", drawing_.fields.size()));
  for (const std::string& word : values) values_.check(word);
}

Demand LiveRun::demand() const {
  const std::lock_guard lock(mutex_);
  return demand_;
}

// ---- the thread that steps ----

void LiveRun::loop() {
  bool waits_for_page = !request_.paused && request_.recording.empty();
  try {
    if (waits_for_page && request_.at_once) startRunning();
    if (!request_.recording.empty()) seek(0);
  } catch (const std::exception& error) {
    endRun(error.what());
  }
  while (!stopping_) {
    try {
      doOrders();
      if (waits_for_page && connected_ && !running_ && ended_.empty()) startRunning();
      if (connected_ || running_) waits_for_page = false;
      if (running_ && secondsAhead() > 0)
        waitForRealTime();
      else if (running_ && !stopping_)
        advance(steps_per_call);
      if (running_ || stopping_) continue;
      showIfDue();
      tellStatus(false);
    } catch (const std::exception& error) {  // of what is only looked at
      endRun(error.what());
      dirty_ = false;
    }
    std::unique_lock lock(mutex_);
    // woken by orders and by pages that have drawn; a picture that is due a little later takes a short sleep
    if (!stopping_ && orders_.empty())
      changed_.wait_for(lock, dirty_ && can_draw_ ? std::chrono::milliseconds(4) : std::chrono::milliseconds(500));
  }
  hands_.forget();
}

void LiveRun::startRunning() {
  if (!request_.recording.empty()) throw ComponentError("a recording is not run", "seek");
  if (!ended_.empty()) throw ComponentError("the run has ended: " + ended_, "reset");
  running_ = true;
  anchor_ = Clock::now(), anchor_time_ = time();
  window_ = {.start = anchor_};
}

double LiveRun::time() const {
  if (request_.recording.empty()) return simulation_.time();
  return request_.recording.front()[std::size_t(index_)].time;
}

void LiveRun::advance(long steps) {
  RunLimits limits;
  limits.steps = steps;
  if (request_.before_step) limits.before_step = [this](Simulation&) { request_.before_step(); };
  limits.after_step = [this](const StepReport& report, double seconds) { afterStep(report, seconds); };
  limits.reached = [this](const Simulation&) {
    if (running_) waitForRealTime();
    return mustReturn();
  };
  try {
    const RunReport report = session_.run(limits);
    if (report.end == RunEnd::output_failed)
      endWithoutOutput(report.reason);
    else if (report.end != RunEnd::done && report.end != RunEnd::stopped)
      endRun(report.reason.empty() ? "the run has no result" : report.reason);
  } catch (const OutputError& error) {
    endWithoutOutput(error.what());
  } catch (const std::exception& error) {
    endRun(error.what());
  }
}

void LiveRun::afterStep(const StepReport& report, double seconds) {
  if (request_.after_step) request_.after_step();
  last_ = report;
  last_step_seconds_ = seconds;
  dirty_ = true;
  if (replayed(simulation_) != replayed_) {  // an edit may have been among them
    replayed_ = replayed(simulation_);
    redraw();
  }
  window_.steps += 1;
  window_.simulated += simulation_.dt();
  window_.stepping += seconds;
  hands_.orderedIsDrawn();
  if (!connected_.load(std::memory_order_relaxed)) return;
  showIfDue();
  tellStatus(false);
}

void LiveRun::endWithoutOutput(const std::string& sentence) {
  if (request_.output_failed) request_.output_failed(sentence);
  endRun(sentence);
}

void LiveRun::endRun(const std::string& sentence) {
  running_ = false;
  ended_ = sentence;
  dirty_ = true;
  audience_.send(Audience::everybody, {{"is", "messages"}, {"lines", {{{"severity", "error"}, {"text", ended_}}}}});
  if (request_.ended) request_.ended(ended_);
  tellStatus(true);
}

double LiveRun::secondsAhead() const {
  return real_time_ ? (time() - anchor_time_) / factor_ - secondsBetween(anchor_, Clock::now()) : 0;
}

void LiveRun::waitForRealTime() {
  const double ahead = secondsAhead();
  if (ahead < -0.25) anchor_ = Clock::now(), anchor_time_ = time();  // what is lost is lost: no rush to catch up
  if (ahead <= 0) return;
  showIfDue();
  const auto until = Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(ahead));
  while (Clock::now() < until && !mustReturn()) {
    showIfDue();
    std::unique_lock lock(mutex_);
    if (!stopping_ && orders_.empty())
      changed_.wait_until(lock,
                          dirty_ && can_draw_ ? std::min(until, Clock::now() + std::chrono::milliseconds(2)) : until);
  }
}

// ---- pictures ----

void LiveRun::showIfDue() {
  if (!can_draw_.load(std::memory_order_relaxed) || !dirty_ || generation_ == 0) return;
  const auto now = Clock::now();
  const Demand wanted = demand();
  const auto period = std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(1 / wanted.fps));
  if (now - last_shown_ < period) return;
  // a picture that is a little late does not make all later ones late
  last_shown_ = now - last_shown_ < 2 * period ? last_shown_ + period : now;
  show(wanted);
}

void LiveRun::show(const Demand& wanted) {
  const auto start = Clock::now();
  const double fields_before = frames_.fieldSeconds();
  if (numbers_.isUntold()) sendScene(Audience::everybody);
  if (wanted.all_nodes && !cells_sent_) {
    audience_.sendPacket(Audience::everybody, cellsPacket(drawing_, generation_));
    cells_sent_ = true;
  }
  if (const long revision = heldRevision(simulation_); revision != held_revision_) {
    audience_.sendPacket(Audience::everybody, heldPacket(simulation_, drawing_, generation_, time()));
    held_revision_ = revision;
  }
  const std::shared_ptr<Packet> frame = frames_.make(wanted, ++frame_, time(), !running_);
  json& header = frame->header();
  header["generation"] = generation_, header["run"] = run_;
  header["hands"] = hands_.describe();
  header["values"] = values_.read(wanted.values, last_, 1e3 * last_step_seconds_, !running_);
  header["applied"] = json::object();
  for (const auto& [client, sequence] : hands_.drawn()) header["applied"][std::to_string(client)] = sequence;
  if (!request_.recording.empty()) header["index"] = index_;
  can_draw_ = false;
  dirty_ = false;
  audience_.show(frame);
  const double fields = frames_.fieldSeconds() - fields_before;
  window_.fields += fields;
  window_.copying += secondsBetween(start, Clock::now()) - fields;
}

/// Now and then, and at most for a hundredth of the time.
void LiveRun::lookForDoubts() {
  const auto start = Clock::now();
  if (simulation_.steps() == 0) doubts_.clear();
  if (start < doubts_due_ || simulation_.steps() == 0 || !request_.recording.empty()) return;
  doubts_due_ = start + std::chrono::seconds(2);
  try {
    doubts_ = doubtsOf(simulation_);
  } catch (const std::exception& error) {  // the way here may be that of a run that has just failed
    doubts_ = {error.what()};
  }
  const auto now = Clock::now();
  doubts_due_ = now + std::max<Clock::duration>(std::chrono::seconds(2), 100 * (now - start));
}

json LiveRun::status() const {
  json out{{"is", "status"},
           {"running", running_},
           {"pace", real_time_ ? "real" : "fast"},
           {"factor", factor_},
           {"time", time()},
           {"step", simulation_.steps()},
           {"dt", simulation_.dt()},
           {"ended", ended_},
           {"doubts", doubts_},
           {"mode", request_.recording.empty() ? "live" : "recording"}};
  out.update(speed_);
  if (!request_.recording.empty()) out["recording"] = {{"count", request_.recording.front().size()}, {"index", index_}};
  return out;
}

void LiveRun::tellStatus(bool now) {
  if (!connected_.load(std::memory_order_relaxed)) return;
  const auto time_now = Clock::now();
  if (!now && time_now - last_status_ < status_period) return;
  last_status_ = time_now;
  const double wall = secondsBetween(window_.start, time_now);
  if (running_ && wall >= 0.2)
    speed_ = {
        {"ratio", window_.simulated / wall},
        {"steps_per_second", double(window_.steps) / wall},
        {"step_ms", window_.steps > 0 ? 1e3 * window_.stepping / double(window_.steps) : 0.},
        {"share",
         {{"step", window_.stepping / wall}, {"copy", window_.copying / wall}, {"fields", window_.fields / wall}}}};
  if (running_ && wall >= window_seconds) window_ = {.start = time_now};
  lookForDoubts();
  audience_.tellStatus(status());
}

}  // namespace stroma::view
