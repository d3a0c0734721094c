// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/stress/table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>

namespace stroma::stress {
namespace {

constexpr std::size_t most_kinds = 12;  ///< of sentences on the terminal; the page has all

std::string firstLine(const std::string& text) { return text.substr(0, text.find('\n')); }

void appendLikes(std::string& text, const Findings& findings, Ending ending, const char* title) {
  const std::vector<Like> all = alike(findings, ending);
  if (all.empty()) return;
  text += fmt::format("\n{}\n", title);
  for (std::size_t k = 0; k < std::min(all.size(), most_kinds); ++k) {
    const Result& first = *all[k].cases.front();
    const std::string more = all[k].cases.size() > 1 ? fmt::format(" and {} more", all[k].cases.size() - 1) : "";
    text +=
        fmt::format("  case {}{}: {}\n    {}\n", first.what.number, more, first.what.text, firstLine(all[k].sentence));
  }
  if (all.size() > most_kinds)
    text += fmt::format("  and {} other sentences: the page has all\n", all.size() - most_kinds);
}

}  // namespace

std::string withoutNumbers(const std::string& text) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    // attributes that are refused alike
    if (text[i] == '/' && (out.empty() || out.back() == ' ')) {
      const std::size_t end = std::min(text.find_first_of(" :;,", i), text.size());
      if (text.find('.', i) < end) {
        out += "/#";
        i = end - 1;
        continue;
      }
    }
    const bool digit = std::isdigit(static_cast<unsigned char>(text[i])) != 0;
    if (!digit)
      out += text[i];
    else if (out.empty() || out.back() != '#')
      out += '#';
  }
  for (const char* piece : {"#.#", "#e-#", "#e+#", "-#", "# # #"})
    for (std::size_t at = out.find(piece); at != std::string::npos; at = out.find(piece))
      out.replace(at, std::string(piece).size(), "#");
  return out;
}

long Findings::count(Ending ending) const {
  return std::count_if(results.begin(), results.end(), [&](const Result& one) { return one.outcome.ending == ending; });
}

std::vector<Like> alike(const Findings& findings, Ending ending) {
  std::vector<Like> all;
  std::map<std::string, std::size_t> known;
  for (const Result& result : findings.results) {
    if (result.outcome.ending != ending) continue;
    const std::string sentence = result.outcome.sentences.empty() ? "" : result.outcome.sentences.front();
    const auto [entry, is_new] = known.emplace(withoutNumbers(firstLine(sentence)), all.size());
    if (is_new) all.push_back({sentence, {}});
    all[entry->second].cases.push_back(&result);
  }
  std::stable_sort(all.begin(), all.end(),
                   [](const Like& a, const Like& b) { return a.cases.size() > b.cases.size(); });
  return all;
}

std::string quoted(const std::string& word) {
  if (!word.empty() &&
      word.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_./=:,+-@") ==
          std::string::npos)
    return word;
  std::string text = "'";
  for (const char c : word) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return text + "'";
}

std::string optionsOf(const StressRequest& request, const std::vector<Override>& more) {
  std::vector<Override> all = request.overrides;
  all.insert(all.end(), more.begin(), more.end());
  std::string text;
  for (const Override& one : all)
    if (one.path == "/" && one.attribute == "dialect") {
      text += " --dialect " + one.value;
    } else {
      const std::string dot = one.path == "/" || one.attribute.empty() ? "" : ".";
      text += " --set " + quoted((one.path == "/" ? "" : one.path) + dot + one.attribute + "=" + one.value);
    }
  for (const std::string& module : request.modules) text += " --module " + quoted(module);
  return text;
}

std::string commandOf(const StressRequest& request, long steps, long number) {
  const std::string scene =
      std::filesystem::path(request.scene).lexically_proximate(std::filesystem::current_path()).string();
  return fmt::format("stroma stress {}{} -n {} --seed {} --case {}", quoted(scene), optionsOf(request, {}), steps,
                     request.seed, number);
}

std::string tableOf(const Findings& findings) {
  std::vector<std::string> groups;
  std::map<std::string, std::array<long, endings>> counts;
  for (const Result& result : findings.results) {
    if (!counts.contains(result.what.group)) groups.push_back(result.what.group);
    ++counts[result.what.group][std::size_t(result.outcome.ending)];
  }
  std::string text = fmt::format("{:24}{:>7}", "", "cases");
  for (int e = 0; e < endings; ++e) text += fmt::format("{:>11}", wordOf(Ending(e)));
  text += "\n";
  std::array<long, endings> sums{};
  const auto line = [&](const std::string& name, const std::array<long, endings>& row) {
    long sum = 0;
    std::string cells;
    for (const long count : row)
      sum += count, cells += count ? fmt::format("{:>11}", count) : fmt::format("{:>11}", ".");
    text += fmt::format("{:24}{:>7}{}\n", name, sum, cells);
  };
  for (const std::string& group : groups) {
    line(group, counts[group]);
    for (std::size_t e = 0; e < endings; ++e) sums[e] += counts[group][e];
  }
  line("all", sums);
  appendLikes(text, findings, Ending::breaks, "breaks:");
  appendLikes(text, findings, Ending::elsewhere, "at rest elsewhere, without a warning:");
  appendLikes(text, findings, Ending::doubt, "in doubt, with these sentences:");
  appendLikes(text, findings, Ending::stops, "stops, with these sentences:");
  appendLikes(text, findings, Ending::unfinished, "unfinished:");
  return text;
}

nlohmann::ordered_json jsonOf(const Findings& findings) {
  nlohmann::ordered_json json{
      {"scene", findings.request.scene}, {"seed", findings.request.seed}, {"steps", findings.steps}};
  json["open"] = findings.open;
  json["doubts_undisturbed"] = findings.doubts;
  for (int e = 0; e < endings; ++e) json["endings"][wordOf(Ending(e))] = findings.count(Ending(e));
  json["cases"] = nlohmann::ordered_json::array();
  for (const Result& result : findings.results) {
    nlohmann::ordered_json one{{"case", result.what.number}, {"group", result.what.group}, {"text", result.what.text}};
    one.update(toJson(result.outcome));
    one["repeat"] = commandOf(findings.request, findings.steps, result.what.number);
    json["cases"].push_back(std::move(one));
  }
  return json;
}

}  // namespace stroma::stress
