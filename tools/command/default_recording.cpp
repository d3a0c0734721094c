// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/command/default_recording.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <set>

#include "framework/scene/output_file.h"
#include "tools/units/unit_system.h"

namespace stroma::command {
namespace {

constexpr std::size_t most_bytes =
    48u << 20;  // of the instants; a checkpoint of as many nodes is smaller than the rest
constexpr long between = 20;
// a run of very many steps is often ended before its last one: it begins with a shorter stride, which grows
constexpr long longest_first_stride = 1000;
constexpr std::size_t most_instants = 2 * between + 2;
constexpr long never = std::numeric_limits<long>::max();
constexpr double never_seconds = std::numeric_limits<double>::infinity();

}  // namespace

std::string lastFolder(const std::string& scene) {
  return (fs::path("results") / fs::path(scene).stem() / "last").string();
}

std::vector<std::string> lastFiles(const std::string& scene) {
  return {instantsFile(lastFolder(scene)), checkpointIn(lastFolder(scene))};
}

DefaultRecording::DefaultRecording(Session& session, const RunRequest& request, long steps)
    : session_(session),
      simulation_(session.simulation()),
      folder_(lastFolder(request.scene)),
      states_(session.simulation().states()) {
  checkPlace();
  std::error_code error;
  goes_on_in_place_ = fs::equivalent(request.restart_file, checkpointIn(folder_), error);
  if (goes_on_in_place_) own_checkpoint_ = identityOf(checkpointIn(folder_));
  write_every_ = request.checkpoint_seconds > 0 ? request.checkpoint_seconds : never_seconds;
  head_ = {request.scene, fs::current_path(error).string(), request.overrides, request.modules, sizesOf(simulation_), 0, {}};
  each_ = head_.instantBytes();
  most_ = states_.empty() ? 0 : std::min(most_bytes / each_, most_instants);
  const long room = most_ > 2 ? std::min(between, mostStrided() - 1) : 0;
  const long made = std::max(1L, steps - simulation_.steps());
  every_ = room > 0 ? std::min((made + room - 1) / room, longest_first_stride) : never;
  bytes_.reserve(each_ * std::min(most_, std::size_t(made / every_) + 3));
}

/// A folder that is there is replaced only when a run left it so.
void DefaultRecording::checkPlace() {
  std::error_code error;
  reason_ = reasonToKeep(folder_);
  if (fs::symlink_status(folder_, error).type() != fs::file_type::not_found) return;
  try {
    checkAccess(instantsFile(folder_), true);
  } catch (const OutputError& failure) {
    reason_ = failure.what();
  }
}

void DefaultRecording::begin() {
  next_ = never;
  if (!reason_.empty() || most_ < 2) {
    write_every_ = never_seconds;
    return;
  }
  next_ = simulation_.steps();
  keep();
}

void DefaultRecording::keep() {
  if (last_ == simulation_.steps()) return;
  last_ = simulation_.steps();
  if (every_ != never && long(kept_.size()) >= mostStrided()) thin();
  append();
  while (every_ != never && kept_.size() > 2 && contentsBytes() > most_bytes) thin();
  next_ = every_ == never ? never : last_ + every_;
}

/// The present instant, and the meshes that it is of.
void DefaultRecording::append() {
  simulation_.complete();
  if (simulation_.hasChangedMeshes() && meshes_.count(session_.meshChanges()) == 0) takeMeshes();
  const std::size_t before = bytes_.size();
  appendInstant(bytes_, simulation_.time(), states_);
  kept_.push_back({bytes_.size() - before, simulation_.hasChangedMeshes() ? session_.meshChanges() : 0});
}

void DefaultRecording::takeMeshes() {
  states_ = simulation_.states();
  Meshes& meshes = meshes_[session_.meshChanges()];
  meshes.bytes = session_.checkpoint().bytes();
  const std::vector<StateSize> sizes = sizesOf(simulation_);
  for (const StateSize& state : head_.states) {
    const auto found = std::ranges::find(sizes, state.path, &StateSize::path);
    meshes.nodes.push_back(found == sizes.end() ? 0 : found->nodes);
  }
}

std::size_t DefaultRecording::contentsBytes() const {
  std::size_t bytes = bytes_.size();
  for (const auto& [change, meshes] : meshes_) bytes += meshes.bytes.size();
  return bytes;
}

/// Every second instant, and twice the stride: room for as many again.
void DefaultRecording::thin() {
  std::vector<Kept> kept;
  std::set<long> needed{simulation_.hasChangedMeshes() ? session_.meshChanges() : 0};
  std::size_t from = 0, to = 0;
  for (std::size_t i = 0; i < kept_.size(); from += kept_[i++].bytes) {
    if (i % 2 != 0) continue;
    std::copy_n(bytes_.data() + from, kept_[i].bytes, bytes_.data() + to);
    to += kept_[i].bytes;
    kept.push_back(kept_[i]), needed.insert(kept_[i].meshes);
  }
  kept_ = std::move(kept);
  bytes_.resize(to);
  std::erase_if(meshes_, [&needed](const auto& each) { return needed.count(each.first) == 0; });
  every_ *= 2;
}

/// The file, in the order of its parts; what `head` says last.
std::vector<std::string_view> DefaultRecording::parts(std::string& head) const {
  InstantsHead all = head_;
  all.instants = kept_.size();
  std::vector<std::string_view> parts{bytes_};
  for (std::size_t i = 0; i < kept_.size(); ++i) {
    if (kept_[i].meshes == 0 || (i > 0 && kept_[i - 1].meshes == kept_[i].meshes)) continue;
    const Meshes& meshes = meshes_.at(kept_[i].meshes);
    all.meshes.push_back({i, meshes.bytes.size(), meshes.nodes});
    parts.push_back(meshes.bytes);
  }
  head = all.line();
  return parts;
}

bool DefaultRecording::write(bool is_needed, bool may_go_on) {
  if (reason_.empty()) checkPlace();
  if (!reason_.empty() || states_.empty()) return false;
  if (most_ == 0 && !is_needed) {
    reason_ = fmt::format("an instant of this scene has {} MB: --record DIR keeps it", each_ >> 20);
    return false;
  }
  every_ = never;
  keep();
  // a run that fails does not take away what it went on from
  const bool with_checkpoint = may_go_on && !(goes_on_in_place_ && is_needed);
  try {
    putInPlace(with_checkpoint);
    has_checkpoint_ = with_checkpoint;
  } catch (const std::runtime_error& failure) {
    reason_ = failure.what();
  }
  return reason_.empty();
}

void DefaultRecording::putInPlace(bool with_checkpoint) {
  std::optional<FileIdentity> own = own_checkpoint_;
  replaceFiles(folder_, own_checkpoint_, [&](const std::string& fresh) {
    std::string head;
    const std::vector<std::string_view> rest = parts(head);
    writeWholeFile(instantsFile(fresh), head, rest);
    if (!with_checkpoint) return;
    session_.writeCheckpoint(checkpointIn(fresh));
    own = identityOf(checkpointIn(fresh));
  });
  own_checkpoint_ = own;
  written_time_ = simulation_.time();
}

/// As if the run ended here. What cannot be written now is tried again later, and told of at the end.
void DefaultRecording::writeMeanwhile() {
  seconds_ = 0;
  const std::size_t bytes = bytes_.size(), count = kept_.size();
  if (last_ != simulation_.steps()) append();
  try {
    putInPlace(!goes_on_in_place_);
  } catch (const std::runtime_error&) {
  }
  bytes_.resize(bytes), kept_.resize(count);
}

std::string DefaultRecording::rest() const {
  if (written_time_)
    return fmt::format("; {} has the run up to t = {:.6g}{}", folder_, *written_time_,
                       unitsOf(simulation_.scene()).behind("s"));
  const bool is_runs = reasonToKeep(folder_).empty() && isInstantsFile(instantsFile(folder_));
  return is_runs ? fmt::format("; {} is that of a run before", folder_) : "";
}

std::vector<std::string> DefaultRecording::files() const {
  std::vector<std::string> files{instantsFile(folder_)};
  if (has_checkpoint_) files.push_back(checkpointIn(folder_));
  return files;
}

}  // namespace stroma::command
