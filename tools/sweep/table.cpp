// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/sweep/table.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>

#include "framework/scene/text.h"
#include "tools/sweep/cores.h"
#include "tools/sweep/richardson.h"

namespace stroma::sweep {
namespace {

using Json = nlohmann::ordered_json;

long number(const nlohmann::json& summary, std::initializer_list<const char*> path) {
  const nlohmann::json* at = &summary;
  for (const char* key : path) {
    if (!at->is_object() || !at->contains(key)) return 0;
    at = &(*at)[key];
  }
  return at->is_number() ? at->get<long>() : 0;
}

Json settingsOf(const std::vector<Axis>& axes, const Configuration& configuration) {
  Json settings = Json::object();
  for (std::size_t a = 0; a < configuration.choice.size(); ++a)
    for (std::size_t i = 0; i < axes[a].attributes.size(); ++i)
      settings[axes[a].attributes[i]] = axes[a].values[configuration.choice[a]][i];
  return settings;
}

/// Figures of the runs of an entry.
Json figuresOf(const Entry& entry, bool timed) {
  Json row;
  const auto& runs = entry.runs.repetitions;
  const nlohmann::json none = nlohmann::json::object();
  const nlohmann::json& summary = runs.empty() ? none : runs.front().summary;
  const bool has_times = timed && entry.runs.isGood() && entry.runs.hasTimes();
  const auto time = [&](double value) { return has_times ? Json(value) : Json(); };
  row["seconds"] = time(entry.runs.medianOf(&Repetition::seconds));
  row["seconds_spread"] = time(entry.runs.spreadOf(&Repetition::seconds));
  row["ms_per_step"] = time(entry.runs.medianOf(&Repetition::step_ms));
  row["load_seconds"] = time(entry.runs.medianOf(&Repetition::load_seconds));
  row["runs"] = runs.size();
  row["timed"] = has_times;
  row["disturbed"] = entry.runs.wereDisturbed();
  row["steps"] = number(summary, {"steps"});
  row["newton_iterations"] = number(summary, {"newton", "iterations"});
  row["linear_iterations"] = number(summary, {"linear", "iterations"});
  row["factorisations"] = number(summary, {"linear", "factorisations"});
  row["peak_memory_bytes"] = number(summary, {"peak_memory_bytes"});
  row["warnings"] = summary.contains("warnings") ? summary["warnings"].size() : 0;
  row["nodes"] = entry.nodes;
  row["cells"] = entry.cells;
  row["spacing"] = entry.spacing;
  row["dt"] = entry.dt;
  row["threads"] = entry.configuration.threads;
  return row;
}

Json runOf(const Repetition& run) {
  return {{"seconds", run.seconds},
          {"ms_per_step", run.step_ms},
          {"process_seconds", run.process_seconds},
          {"others_seconds", run.others_seconds},
          {"cpu_seconds", run.cpu_seconds},
          {"timed", run.timed},
          {"disturbed", run.wasDisturbed()},
          {"cores", run.cores},
          {"beside", run.beside},
          {"load_at_start", run.load},
          {"machine", run.machine}};
}

/// Null where nothing tells it.
Json uncertaintyOf(const Assessment& assessment) {
  return assessment.knowledge == Knowledge::none ? Json() : Json(assessment.uncertainty);
}

Json rowOf(const Findings& findings, const Entry& entry) {
  Json row;
  row["name"] = nameOf(findings.axes, entry.configuration);
  row["key"] = entry.configuration.key;
  row["settings"] = settingsOf(findings.axes, entry.configuration);
  row["outcome"] = entry.runs.outcome;
  if (!entry.runs.failure.empty()) row["sentence"] = entry.runs.failure;
  row["error"] = entry.error ? Json(*entry.error) : Json();
  row["error_uncertainty"] = entry.error ? uncertaintyOf(findings.assessment) : Json();
  if (!entry.value.empty()) row["value"] = entry.value.size() == 1 ? Json(entry.value[0]) : Json(entry.value);
  row["is_reference"] = entry.is_reference;
  row["on_front"] = entry.on_front;
  row.update(figuresOf(entry, findings.request.timed));
  if (entry.outside > 0) row["points_outside"] = {{"count", entry.outside}, {"farthest", entry.farthest}};
  row["measured"] = Json::array();
  for (const Repetition& run : entry.runs.repetitions) row["measured"].push_back(runOf(run));
  row["command"] = commandLine(findings.request, entry.configuration);
  return row;
}

std::string csvField(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string quoted_text = "\"";
  for (const char c : text) quoted_text += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted_text + "\"";
}

std::string csvField(const Json& value) {
  if (value.is_null()) return "";
  if (value.is_array()) return fmt::format("{}", fmt::join(value.get<std::vector<double>>(), " "));
  return csvField(value.is_string() ? value.get<std::string>() : value.dump());
}

}  // namespace

std::vector<Series> seriesOf(const Findings& findings) {
  std::vector<Series> all;
  for (std::size_t a = 0; a < findings.axes.size(); ++a) {
    const Axis& axis = findings.axes[a];
    if (!axis.isOrdered()) continue;
    std::map<std::vector<std::size_t>, Series> lines;
    for (const Entry& entry : findings.entries) {
      if (!entry.error || entry.configuration.isExtraReference()) continue;
      std::vector<std::size_t> others = entry.configuration.choice;
      others.erase(others.begin() + std::ptrdiff_t(a));
      lines[others].entries.push_back(&entry);
    }
    for (auto& [others, series] : lines) {
      if (series.entries.size() < 2) continue;
      series.axis = a;
      const auto& choice = series.entries.front()->configuration.choice;
      for (std::size_t b = 0; b < findings.axes.size(); ++b)
        if (b != a) series.name += (series.name.empty() ? "" : ", ") + findings.axes[b].settingText(choice[b]);
      std::ranges::sort(series.entries, [&](const Entry* one, const Entry* other) {
        return axis.isFiner(other->configuration.choice[a], one->configuration.choice[a]);
      });
      std::vector<double> sizes, errors;
      for (const Entry* entry : series.entries) {
        // an error of the size of the reference's own tells no slope
        if (entry->is_reference || *entry->error < 2 * findings.assessment.expected) continue;
        sizes.push_back(axis.sizes[entry->configuration.choice[a]]), errors.push_back(*entry->error);
      }
      if (axis.hasOrder() && sizes.size() >= 3) series.order = slopeOf(sizes, errors);
      all.push_back(std::move(series));
    }
  }
  return all;
}

std::string csvOf(const Findings& findings) {
  std::string text;
  std::vector<std::string> attributes;
  for (const Axis& axis : findings.axes)
    attributes.insert(attributes.end(), axis.attributes.begin(), axis.attributes.end());
  for (const std::string& attribute : attributes) text += csvField(attribute) + ",";
  const std::vector<std::string> columns{"error",
                                         "error_uncertainty",
                                         "value",
                                         "seconds",
                                         "seconds_spread",
                                         "ms_per_step",
                                         "load_seconds",
                                         "steps",
                                         "newton_iterations",
                                         "linear_iterations",
                                         "peak_memory_bytes",
                                         "nodes",
                                         "cells",
                                         "spacing",
                                         "dt",
                                         "threads",
                                         "runs",
                                         "timed",
                                         "disturbed",
                                         "on_front",
                                         "is_reference",
                                         "warnings",
                                         "outcome",
                                         "sentence",
                                         "key",
                                         "command"};
  text += fmt::format("{}\n", fmt::join(columns, ","));
  for (const Entry& entry : findings.entries) {
    const Json row = rowOf(findings, entry);
    for (const std::string& attribute : attributes)
      text += (row["settings"].contains(attribute) ? csvField(row["settings"][attribute]) : "") + ",";
    for (std::size_t c = 0; c < columns.size(); ++c)
      text += (c ? "," : "") + (row.contains(columns[c]) ? csvField(row[columns[c]]) : std::string());
    text += "\n";
  }
  return text;
}

Json jsonOf(const Findings& findings) {
  const SweepRequest& request = findings.request;
  const Assessment& assessment = findings.assessment;
  Json json;
  json["scene"] = request.scene;
  json["command"] = commandLine(request);
  json["stroma"] = STROMA_VERSION;
  json["build"] = findings.build;
  json["scene_digest"] = findings.scene_digest;
  json["machine"] = machineText();
  json["seed"] = request.seed;
  json["repeat"] = request.repeat;
  json["error"] = {{"measure", request.error},
                   {"relative", assessment.is_relative},
                   {"uncertainty", uncertaintyOf(assessment)},
                   {"uncertainty_is_whole", assessment.knowledge == Knowledge::whole}};
  json["units"] = {{"length", assessment.length_unit}, {"time", assessment.time_unit}};
  json["reference"] = assessment.reference;
  json["estimates"] = Json::array();
  for (const AxisEstimate& axis : assessment.axes)
    json["estimates"].push_back({{"axis", findings.axes[axis.axis].label()},
                                 {"order", axis.order ? Json(*axis.order) : Json()},
                                 {"uncertainty", axis.uncertainty},
                                 {"how", axis.how}});
  json["series"] = Json::array();
  for (const Series& series : seriesOf(findings))
    json["series"].push_back({{"axis", findings.axes[series.axis].label()},
                              {"others", series.name},
                              {"order", series.order ? Json(*series.order) : Json()},
                              {"results", series.entries.size()}});
  json["notes"] = assessment.notes;
  json["not_run"] = findings.not_run;
  if (!findings.goal.empty()) {
    json["goal"] = {{"asked", request.goal}, {"result", findings.goal}};
    if (findings.cheapest) json["goal"]["command"] = commandLine(request, findings.cheapest->configuration);
  }
  json["configurations"] = Json::array();
  for (const Entry& entry : findings.entries) json["configurations"].push_back(rowOf(findings, entry));
  return json;
}

}  // namespace stroma::sweep
