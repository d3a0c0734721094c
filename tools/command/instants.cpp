// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/command/instants.h"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "framework/mechanics/frames.h"
#include "framework/scene/output_file.h"

namespace stroma::command {
namespace {

using Json = nlohmann::ordered_json;
constexpr std::string_view beginning = R"({"stroma":"instants","version":1,)", changed = R"({"stroma":"instants","version":2,)";
static_assert(beginning.size() == changed.size());

[[noreturn]] void fail(const std::string& file, const std::string& what) {
  throw std::runtime_error(fmt::format("{}: {}", file, what));
}

/// What is read of a file, up to and with the first line.
InstantsHead takeHead(std::istream& stream, const std::string& file) {
  std::string line;
  std::getline(stream, line);
  if (!line.starts_with(beginning) && !line.starts_with(changed))
    fail(file, fmt::format("these are no instants (expected a file that starts with {})", beginning));
  try {
    const Json json = Json::parse(line);
    InstantsHead head{json.at("scene"), json.at("folder"), json.at("set"), json.at("modules"), {}, 0, {}};
    for (const Json& state : json.at("states")) head.states.push_back({state.at("path"), state.at("nodes")});
    if (line.starts_with(beginning)) return head;
    const auto countOf = [&file](const Json& number) {
      if (number.get<double>() < 0 || number.get<double>() > 1e12) fail(file, "the first line is damaged (a number out of range)");
      return number;
    };
    head.instants = countOf(json.at("instants"));
    for (const Json& meshes : json.at("meshes")) {
      head.meshes.push_back({countOf(meshes.at("from")), countOf(meshes.at("bytes")), meshes.at("nodes")});
      if (head.meshes.back().nodes.size() != head.states.size()) fail(file, "the first line is damaged (nodes of each state)");
    }
    return head;
  } catch (const Json::exception& error) {
    fail(file, fmt::format("the first line is damaged ({})", error.what()));
  }
}

std::ifstream opened(const std::string& file) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) fail(file, fmt::format("cannot open ({})", std::strerror(errno)));
  return stream;
}

const double* takeRows(const double* from, Index count, std::vector<Vec3>& rows) {
  for (Index i = 0; i < count; ++i, from += 3) rows.emplace_back(from[0], from[1], from[2]);
  return from;
}

}  // namespace

std::string instantsFile(const std::string& folder) {
  return (std::filesystem::path(folder) / "run.instants").string();
}

bool isInstantsFile(const std::string& file) {
  std::string start(beginning.size(), ' ');
  std::ifstream stream(file, std::ios::binary);
  return stream.read(start.data(), std::streamsize(start.size())) && (start == beginning || start == changed);
}

std::vector<StateSize> sizesOf(const Simulation& simulation) {
  std::vector<StateSize> sizes;
  for (const State* state : simulation.states()) sizes.push_back({state->path(), state->size()});
  return sizes;
}

void appendInstant(std::string& bytes, double time, const std::vector<State*>& states) {
  std::size_t at = bytes.size(), nodes = 0;
  for (const State* state : states) nodes += std::size_t(state->size());
  bytes.resize(at + (1 + 6 * nodes) * sizeof(double));
  const auto append = [&](const double* numbers, std::size_t count) {
    std::memcpy(bytes.data() + at, numbers, count * sizeof(double));
    at += count * sizeof(double);
  };
  append(&time, 1);
  for (const State* state : states) {
    for (Index i = 0; i < state->size(); ++i) append(valueOfRow(state->kindOf(i), state->x(), i).data(), 3);
    for (Index i = 0; i < state->size(); ++i) append(state->v()[i].data(), 3);
  }
}

std::vector<Index> InstantsHead::nodesAt(std::size_t instant) const {
  std::vector<Index> nodes;
  for (const StateSize& state : states) nodes.push_back(state.nodes);
  for (const InstantsMeshes& each : meshes)
    if (each.from <= instant) nodes = each.nodes;
  return nodes;
}

std::size_t InstantsHead::instantBytes(std::size_t instant) const {
  std::size_t numbers = 1;
  for (const Index nodes : nodesAt(instant)) numbers += 6 * std::size_t(nodes);
  return numbers * sizeof(double);
}

std::string InstantsHead::line() const {
  Json json = {{"stroma", "instants"}, {"version", meshes.empty() ? 1 : 2}, {"scene", scene},         {"folder", folder},
               {"set", overrides},     {"modules", modules},                {"states", Json::array()}};
  for (const StateSize& state : states) json["states"].push_back({{"path", state.path}, {"nodes", state.nodes}});
  if (!meshes.empty()) json["instants"] = instants, json["meshes"] = Json::array();
  for (const InstantsMeshes& each : meshes)
    json["meshes"].push_back({{"from", each.from}, {"bytes", each.bytes}, {"nodes", each.nodes}});
  return json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

InstantsHead readInstantsHead(const std::string& file) {
  std::ifstream stream = opened(file);
  return takeHead(stream, file);
}

namespace {

/// Reads the head, and checks that the file has all that it says. How many instants there are.
std::size_t checkLength(std::ifstream& stream, const InstantsHead& head, const std::string& file) {
  std::error_code error;
  const std::size_t rest = std::size_t(std::filesystem::file_size(file, error)) - std::size_t(stream.tellg());
  if (head.meshes.empty()) {
    const std::size_t bytes = head.instantBytes();
    if (error || rest == 0 || rest % bytes != 0)
      fail(file, fmt::format("the file is cut short (expected instants of {} bytes each)", bytes));
    return rest / bytes;
  }
  if (head.instants > rest / sizeof(double)) fail(file, fmt::format("the file is cut short (expected {} instants)", head.instants));
  std::size_t bytes = 0;
  for (std::size_t i = 0; i < head.instants; ++i) bytes += head.instantBytes(i);
  for (const InstantsMeshes& each : head.meshes) bytes += each.bytes;
  if (error || rest != bytes) fail(file, fmt::format("the file is cut short (expected {} bytes behind its first line)", bytes));
  return head.instants;
}

}  // namespace

std::vector<std::vector<StateFrame>> readInstants(const std::string& file) {
  std::ifstream stream = opened(file);
  const InstantsHead head = takeHead(stream, file);
  const std::size_t count = checkLength(stream, head, file);
  std::vector<std::vector<StateFrame>> all(head.states.size());
  std::vector<double> instant;
  for (std::size_t i = 0; i < count; ++i) {
    const std::vector<Index> nodes = head.nodesAt(i);
    instant.resize(head.instantBytes(i) / sizeof(double));
    if (!stream.read(reinterpret_cast<char*>(instant.data()), std::streamsize(instant.size() * sizeof(double))))
      fail(file, "cannot be read");
    const double* from = instant.data() + 1;
    for (std::size_t s = 0; s < all.size(); ++s) {
      StateFrame& frame = all[s].emplace_back();
      frame.time = instant[0];
      from = takeRows(from, nodes[s], frame.x);
      from = takeRows(from, nodes[s], frame.v);
    }
  }
  return all;
}

std::vector<std::string> readInstantsMeshes(const std::string& file) {
  std::ifstream stream = opened(file);
  const InstantsHead head = takeHead(stream, file);
  checkLength(stream, head, file);
  std::size_t instants = 0;
  for (std::size_t i = 0; i < head.instants; ++i) instants += head.instantBytes(i);
  stream.seekg(std::streamoff(instants), std::ios::cur);
  std::vector<std::string> all;
  for (const InstantsMeshes& each : head.meshes) {
    std::string& bytes = all.emplace_back(each.bytes, '\0');
    if (!stream.read(bytes.data(), std::streamsize(bytes.size()))) fail(file, "cannot be read");
  }
  return all;
}

}  // namespace stroma::command
