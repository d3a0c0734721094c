// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/command/component_json.h"

#include <fmt/format.h>

#include "framework/scene/change_table.h"
#include "tools/command/command.h"

namespace stroma::command {
namespace {

struct Kinds {
  std::string operator()(const bool*) const { return "boolean"; }
  std::string operator()(const int*) const { return "integer"; }
  std::string operator()(const double*) const { return "real"; }
  std::string operator()(const std::string*) const { return "text"; }
  std::string operator()(const Vec3*) const { return "vector"; }
  std::string operator()(const std::array<int, 3>*) const { return "integer triple"; }
  std::string operator()(const std::array<double, 16>*) const { return "matrix"; }
  std::string operator()(const std::vector<bool>*) const { return "booleans"; }
  std::string operator()(const std::vector<int>*) const { return "integers"; }
  std::string operator()(const std::vector<double>*) const { return "reals"; }
  std::string operator()(const std::vector<Vec3>*) const { return "vectors"; }
  std::string operator()(const std::vector<std::string>*) const { return "words"; }
  template <std::size_t n>
  std::string operator()(const std::vector<std::array<Index, n>>*) const {
    return "indices";
  }
  std::string operator()(const FileName*) const { return "file"; }
  std::string operator()(const ChoiceRef&) const { return "choice"; }
  std::string operator()(const LinkBase*) const { return "link"; }
};

std::vector<std::string> choicesOf(const Data& data) {
  if (const auto* choice = std::get_if<ChoiceRef>(&data.pointer())) return choice->words;
  return data.link() ? data.link()->words : std::vector<std::string>();
}

const char* changesOf(const Data& data) {
  switch (data.changeEffect()) {
    case ChangeEffect::at_once:
      return "at once";
    case ChangeEffect::recompile:
      return "recompile";
    case ChangeEffect::restart:
      break;
  }
  return "restart";
}

Json attributeJson(const Data& data) {
  return {{"name", data.name()},           {"kind", kindOf(data)},
          {"type", data.typeText()},       {"unit", data.unitText()},
          {"default", data.defaultText()}, {"range", data.rangeText()},
          {"help", data.helpText()},       {"aliases", data.aliases()},
          {"required", data.isRequired()}, {"physical", data.isPhysical()},
          {"choices", choicesOf(data)},    {"link", data.link() ? data.link()->roleText() : std::string()},
          {"changes", changesOf(data)}};
}

Json listedJson(const Component& component, const ComponentEntry& entry) {
  return {{"name", entry.type}, {"role", component.roleText()}, {"module", entry.module}, {"help", entry.help}};
}

std::vector<std::string> namesIn(const Modules& modules) {
  std::vector<std::string> names;
  for (const Modules::IndexEntry& entry : modules.index()) names.emplace_back(entry.type);
  return names;
}

}  // namespace

std::vector<std::string> visualOnly(const Component& component) {
  std::vector<std::string> names;
  for (const std::string_view name : visualAttributes())
    if (component.data().isVisualOnly(name)) names.emplace_back(name);
  return names;
}

std::string kindOf(const Data& data) { return std::visit(Kinds(), data.pointer()); }

Json listJson(Session& session, const std::vector<Modules::IndexEntry>& entries) {
  Json list = Json::array();
  for (const Modules::IndexEntry& entry : entries) {
    const std::string type(entry.type);
    session.modules().provide(type);
    list.push_back(listedJson(*session.factory().make(type), *session.factory().find(type)));
  }
  return list;
}

Json docJson(Session& session, const std::string& name) {
  const auto component = session.factory().make(name);
  Json json = listedJson(*component, *session.factory().find(name));
  json["manual"] = session.modules().manual(name);
  Json attributes = Json::array(), outputs = Json::array();
  std::vector<std::string> shorthands;
  for (const Data& data : component->data().all()) {
    if (data.isShorthand())
      shorthands.push_back(data.name());
    else
      (data.isOutput() ? outputs : attributes).push_back(attributeJson(data));
  }
  json["attributes"] = std::move(attributes);
  json["outputs"] = std::move(outputs);
  json["shorthands"] = shorthands;
  json["visual_only"] = visualOnly(*component);
  return json;
}

int docAsJson(const Values& values, const Manual& manual) {
  const bool all = values.count("all") > 0;
  if (all && !values.count("json")) throw UsageError("--all needs --json");
  if (all && values.count("NAME")) throw UsageError("--all and NAME exclude each other");
  Session session;
  configure(session, values);
  if (!all) {
    const std::string given = required(values, "NAME", manual), name(presentType(given));
    if (!session.modules().provide(name)) {
      const std::string near = nearest(given, namesIn(session.modules()));
      throw UsageError(fmt::format("there is no component '{}' ({})", given,
                                   near.empty() ? "stroma list prints them all" : "did you mean " + near + "?"));
    }
    return printJson(docJson(session, session.factory().find(name) ? name : given));
  }
  session.modules().openAll();
  Json list = Json::array();
  for (const ComponentEntry* entry : session.factory().entries()) list.push_back(docJson(session, entry->type));
  return printJson(list);
}

int printJson(const Json& json) {
  fmt::print("{}\n", json.dump(2, ' ', false, Json::error_handler_t::replace));
  return exit_done;
}

}  // namespace stroma::command
