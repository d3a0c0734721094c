// SPDX-License-Identifier: LGPL-2.1-or-later
// What pages ask of a run, and the answers.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "framework/scene/output_file.h"
#include "framework/simulation/run_events.h"
#include "tools/checks/result_doubts.h"
#include "tools/drawing/recording.h"
#include "tools/plan/plan.h"
#include "tools/scene_writer/changed_scene.h"
#include "tools/session/action_file.h"
#include "tools/session/scene_program.h"
#include "tools/session/thread_choice.h"
#include "tools/view/component_tree.h"
#include "tools/view/live_run.h"
#include "tools/view/orders.h"
#include "tools/view/scene_packets.h"

namespace stroma::view {
namespace {

using nlohmann::json;

const char* wordOf(Severity severity) {
  return severity == Severity::error ? "error" : severity == Severity::warning ? "warning" : "note";
}

json lineOf(const Problem& problem) { return {{"severity", wordOf(problem.severity)}, {"text", problem.text()}}; }

std::string fileName(const std::string& path) { return std::filesystem::path(path).filename().string(); }

}  // namespace

void LiveRun::doOrders(bool of_server_only) {
  constexpr auto longest = std::chrono::milliseconds(10);
  const auto start = Clock::now();
  do {
    Order order;
    {
      const std::lock_guard lock(mutex_);
      const auto next = std::find_if(orders_.begin(), orders_.end(), [of_server_only](const Order& waiting) {
        return !of_server_only || isOfServer(waiting.message);
      });
      if (next == orders_.end()) {
        ordered_ = !orders_.empty();
        return;
      }
      order = std::move(*next);
      orders_.erase(next);
    }
    answer(order);
  } while (Clock::now() - start < longest);
}

void LiveRun::answer(const Order& order) {
  std::string message;
  bool good = false;
  try {
    message = carryOut(order);
    good = true;
  } catch (const ComponentError& error) {
    message = sentenceOf(error);
  } catch (const SceneError& error) {
    message = error.diagnostics().text();
  } catch (const std::exception& error) {
    message = error.what();
  }
  if (order.message.contains("request"))
    audience_.send(order.client,
                   {{"is", "reply"}, {"request", order.message["request"]}, {"ok", good}, {"message", message}});
  else if (!good)
    audience_.send(order.client, {{"is", "messages"}, {"lines", {{{"severity", "error"}, {"text", message}}}}});
}

/// Of the pointer.
void LiveRun::tellProgram(const json& message) {
  constexpr long far = 1'000'000;  // [pixels]
  const Mouse mouse{integer(member(message, "state"), "state", 0, 7), integer(member(message, "x"), "x", -far, far),
                    integer(member(message, "y"), "y", -far, far), integer(member(message, "wheel"), "wheel", -far, far)};
  session_.mouse(mouse);
  dirty_ = true;
}

/// Returns what the reply says.
std::string LiveRun::carryOut(const Order& order) {
  const json& message = order.message;
  const std::string verb = text(member(message, "do"), "do", 20);
  if (verb == "attach") {
    introduce(order.client);
  } else if (verb == "leave") {
    hands_.releaseAll(order.client);
    dirty_ = true;
  } else if (verb == "pull" || verb == "force" || verb == "push" || verb == "release") {
    if (!request_.recording.empty()) throw ComponentError("no hand reaches into a recording");
    if (isOutdated(message)) return {};
    hands_.apply(order.client, message);
    if (!running_) hands_.orderedIsDrawn();
    dirty_ = true;
  } else if (verb == "move") {
    moveObstacle(order.client, message);
  } else if (verb == "key") {
    session_.key(text(member(message, "key"), "key", 20), message.value("pressed", true));
    dirty_ = true;
  } else if (verb == "mouse") {
    tellProgram(message);
  } else if (verb == "set") {
    setAttribute(message);
  } else if (verb == "show") {
    dirty_ = true;
  } else if (!carryOutOfRun(verb, message)) {
    tell(order.client, verb);
  }
  return {};
}

/// False for a verb that is none of these.
bool LiveRun::carryOutOfRun(const std::string& verb, const json& message) {
  if (verb == "run") {
    startRunning();
  } else if (verb == "pause") {
    stopIsDone();
    running_ = false;
    dirty_ = true;
  } else if (verb == "step") {
    if (!request_.recording.empty()) throw ComponentError("a recording is not run", "seek");
    if (!ended_.empty()) throw ComponentError("the run has ended: " + ended_, "reset");
    running_ = false;
    const long count = integer(message.value("count", json(1)), "count", 1, 100000);
    for (long i = 0; i < count && ended_.empty() && !stopping_ && !isPauseAsked(); ++i) {
      doOrders(true);
      advance(1);
    }
  } else if (verb == "reset") {
    stopIsDone();
    reset();
  } else if (verb == "pace") {
    const std::string pace = text(member(message, "pace"), "pace", 10);
    if (pace != "real" && pace != "fast") throw ComponentError("'pace' is '" + pace + "'", "real or fast");
    factor_ = number(message.value("factor", json(1)), "factor", 1e-6, 1e6);
    real_time_ = pace == "real";
    anchor_ = Clock::now(), anchor_time_ = time();
  } else if (verb == "seek") {
    if (request_.recording.empty()) throw ComponentError("this run is live", "a recording to seek in");
    seek(integer(member(message, "index"), "index", 0, long(request_.recording.front().size()) - 1));
  } else {
    return false;
  }
  tellStatus(true);
  return true;
}

bool LiveRun::isPauseAsked() const {
  const std::lock_guard lock(mutex_);
  return std::any_of(orders_.begin(), orders_.end(), [](const Order& order) {
    const std::string verb = order.message.value("do", "");
    return verb == "pause" || verb == "reset";
  });
}

void LiveRun::sendScene(int client) {
  Packet scene = scenePacket(simulation_, drawing_, generation_, request_.recording.empty() ? "live" : "recording");
  if (client != Audience::everybody) scene.header()["client"] = client;
  scene.header()["build"] = request_.build;
  scene.header()["keys"] = session_.isProgram();
  if (client == Audience::everybody && numbers_.isUntold()) {
    scene.header()["follows"] = numbers_.toldGeneration();
    for (std::size_t b = 0; b < drawing_.bodies.size(); ++b)
      scene.add(std::to_string(b) + ".before", numbers_.before(drawing_.bodies[b]));
  }
  if (client == Audience::everybody || !numbers_.isUntold()) numbers_.told(drawing_, generation_);
  audience_.sendPacket(client, scene);
  audience_.sendPacket(client, heldPacket(simulation_, drawing_, generation_, time()));
  if (client == Audience::everybody) held_revision_ = heldRevision(simulation_);
  if (cells_sent_) audience_.sendPacket(client, cellsPacket(drawing_, generation_));
}

/// An edit may have joined other nodes: what is drawn is then another scene for the pages.
void LiveRun::redraw() {
  std::vector<DrawnSegments::Segment> segments = segmentsOf(simulation_);
  if (segments == segments_) return;
  Drawing drawing = drawingOf(simulation_);
  segments_ = std::move(segments);
  {
    const std::lock_guard lock(mutex_);
    drawing_ = std::move(drawing);
  }
  if (generation_ == 0) return;
  ++generation_;
  sendScene(Audience::everybody);
}

void LiveRun::meshChanged(const NodesNow& now) {
  {
    Drawing drawing = drawingOf(simulation_);
    const std::lock_guard lock(mutex_);
    drawing_ = std::move(drawing);
    has_changed_meshes_ = true;
  }
  segments_ = segmentsOf(simulation_);
  hands_.follow(now);
  numbers_.follow(drawing_, now);
  frames_.forget();
  held_revision_ = -1;
  dirty_ = true;
  if (generation_ == 0) return numbers_.told(drawing_, 0);
  ++generation_;
  json lines = json::array();
  const std::vector<std::string>& notes = session_.meshNotes();
  for (; notes_told_ < notes.size(); ++notes_told_) lines.push_back({{"severity", "warning"}, {"text", notes[notes_told_]}});
  if (!lines.empty()) audience_.send(Audience::everybody, {{"is", "messages"}, {"lines", lines}});
}

bool LiveRun::isOutdated(const json& message) const {
  return message.contains("generation") && integer(message["generation"], "generation", 0, 1L << 52) != generation_;
}

void LiveRun::introduce(int client) {
  if (generation_ == 0) generation_ = 1;
  sendScene(client);
  json lines = json::array();
  for (const Problem& problem : simulation_.scene().diagnostics.problems()) lines.push_back(lineOf(problem));
  audience_.send(client, {{"is", "messages"}, {"lines", lines}});
  json start = status();
  if (!request_.recording.empty())
    for (const StateFrame& frame : request_.recording.front()) start["recording"]["times"].push_back(frame.time);
  audience_.send(client, start);
  audience_.send(client, {{"is", "ready"}});
  dirty_ = true;
  tellStatus(true);
}

void LiveRun::tell(int client, const std::string& verb) {
  const std::string scene = fileName(simulation_.scene().description.file);
  if (verb == "components") {
    audience_.send(client, {{"is", "components"}, {"tree", componentTree(session_)}});
  } else if (verb == "explain") {
    json lines = planOf(simulation_).lines();
    lines.push_back("threads: " + threadsText(simulation_));
    audience_.send(client, {{"is", "explain"}, {"lines", lines}});
  } else if (verb == "hash") {
    audience_.send(
        client,
        {{"is", "hash"}, {"step", simulation_.steps()}, {"hash", fmt::format("{:016x}", simulation_.stateHash())}});
  } else if (verb == "doubts") {
    audience_.send(client, {{"is", "doubts"}, {"lines", doubtsOf(simulation_)}});
  } else if (verb == "xml") {
    tellXml(client);
  } else if (verb == "actions") {
    audience_.send(client, {{"is", "actions"},
                            {"name", std::filesystem::path(scene).stem().string() + ".actions"},
                            {"text", printActions({scene, simulation_.events()})}});
  } else {
    throw std::logic_error("there is no action called " + verb);  // checkedVerb() lets no other through
  }
}

void LiveRun::tellXml(int client) {
  const ChangedScene changed = changedScene(simulation_);
  const std::string& file = simulation_.scene().description.file;
  const auto own = changed.texts.find(file);
  if (own == changed.texts.end()) throw ComponentError("the scene was not read from a file");
  json lines = json::array(), others = json::array();
  for (const std::string& sentence : changed.not_written)
    lines.push_back({{"severity", "warning"}, {"text", sentence}});
  for (const std::string& sentence : changed.notes) lines.push_back({{"severity", "note"}, {"text", sentence}});
  if (!lines.empty()) audience_.send(client, {{"is", "messages"}, {"lines", lines}});
  for (const std::string& name : changed.changed)
    if (name != file) others.push_back({{"name", fileName(name)}, {"text", changed.texts.at(name)}});
  audience_.send(client, {{"is", "xml"}, {"name", fileName(file)}, {"text", own->second}, {"included", others}});
}

/// The step filter lets obstacles go where their offset leads them: as far as nothing is in their way.
void LiveRun::moveObstacle(int client, const json& message) {
  if (!request_.recording.empty()) throw ComponentError("no hand reaches into a recording");
  if (drawing_.obstacles.empty()) throw ComponentError("the scene has no obstacles");
  const long number = integer(member(message, "obstacle"), "obstacle", 0, long(drawing_.obstacles.size()) - 1);
  const Vec3 offset = place(member(message, "offset"), "offset");
  simulation_.setAttribute(drawing_.obstacles[std::size_t(number)].owner->path(), "offset",
                           fmt::format("{} {} {}", offset[0], offset[1], offset[2]));
  if (message.contains("sequence")) hands_.ordered(client, integer(message["sequence"], "sequence", 0, 1L << 52));
  if (!running_) hands_.orderedIsDrawn();
  dirty_ = true;
}

void LiveRun::setAttribute(const json& message) {
  if (!request_.recording.empty()) throw ComponentError("a recording has no attributes that could change");
  const Diagnostics found = simulation_.setAttribute(text(member(message, "path"), "path", 1000),
                                                     text(member(message, "attribute"), "attribute", 200),
                                                     text(member(message, "value"), "value", 60000));
  if (!found.problems().empty()) {
    json lines = json::array();
    for (const Problem& problem : found.problems()) lines.push_back(lineOf(problem));
    audience_.send(Audience::everybody, {{"is", "messages"}, {"lines", lines}});
  }
  held_revision_ = -1;
  dirty_ = true;
  redraw();
  audience_.send(Audience::everybody, {{"is", "components"}, {"tree", componentTree(session_)}});
}

void LiveRun::reset() {
  if (!request_.recording.empty()) {
    seek(0);
    return;
  }
  std::string failure;
  const bool is_of_changed_mesh = simulation_.hasChangedMeshes();
  try {
    simulation_.reset();
  } catch (const OutputError& error) {  // of an observer that ends; all others have ended
    failure = error.what();
    simulation_.reset();
  }
  hands_.forget();
  if (is_of_changed_mesh) {
    meshChanged(NodesNow(numbers_.firstNodes()));
    numbers_.restart();
  } else {
    redraw();
  }
  ++run_;
  ended_.clear();
  last_ = {}, last_step_seconds_ = 0;
  held_revision_ = -1;
  anchor_ = Clock::now(), anchor_time_ = time();
  dirty_ = true;
  try {
    if (request_.after_reset) request_.after_reset();
    if (!failure.empty()) endWithoutOutput(failure);
  } catch (const OutputError& error) {
    endWithoutOutput(error.what());
    throw;
  }
}

void LiveRun::takeMeshes(const Checkpoint* meshes) {
  if (meshes == meshes_) return;
  if (meshes) {
    session_.restore(*meshes, "the recording");  // which tells meshChanged()
  } else {
    simulation_.reset();
    meshChanged({});
  }
  meshes_ = meshes;  // where they were refused, those before are still there
}

void LiveRun::seek(long index) {
  takeMeshes(meshesAt(request_.recording.front()[std::size_t(index)].time, request_.meshes));
  index_ = index;
  drawing::showInstant(simulation_, request_.recording, std::size_t(index));
  held_revision_ = -1;
  dirty_ = true;
}

}  // namespace stroma::view
