// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/sweep/configuration.h"

#include <fmt/format.h>

#include <cctype>
#include <stdexcept>

#include "framework/scene/text.h"

namespace stroma::sweep {

Configuration configurationOf(const SweepRequest& request, const std::vector<Axis>& axes,
                              const std::vector<std::size_t>& choice) {
  Configuration configuration;
  configuration.choice = choice;
  configuration.settings = request.settings;
  configuration.threads = request.threads;
  for (std::size_t i = 0; i < axes.size(); ++i)
    for (std::size_t a = 0; a < axes[i].attributes.size(); ++a) {
      const std::string& value = axes[i].values[choice[i]][a];
      double count = 0;
      if (axes[i].attributes[a] != "threads") {
        configuration.settings.push_back(axes[i].attributes[a] + "=" + value);
      } else if (readNumber(value, count) && count >= 1 && count <= 1024 && count == int(count)) {
        configuration.threads = int(count);
      } else {
        throw std::invalid_argument(fmt::format("--vary threads={}: expected whole numbers from 1 to 1024", value));
      }
    }
  return configuration;
}

std::vector<Configuration> allConfigurations(const SweepRequest& request, const std::vector<Axis>& axes) {
  constexpr std::size_t most = 100'000;
  std::size_t count = 1;
  for (const Axis& axis : axes)
    if ((count *= axis.size()) > most)
      throw std::invalid_argument(fmt::format("more than {} configurations: expected a smaller grid", most));
  std::vector<Configuration> all;
  for (std::size_t i = 0; i < count; ++i) {
    std::vector<std::size_t> choice(axes.size());
    std::size_t rest = i;
    for (std::size_t a = axes.size(); a-- > 0; rest /= axes[a].size()) choice[a] = rest % axes[a].size();
    all.push_back(configurationOf(request, axes, choice));
  }
  return all;
}

Configuration extraReference(const SweepRequest& request, const std::vector<Axis>& axes) {
  std::vector<std::size_t> choice;
  for (const Axis& axis : axes) choice.push_back(axis.finest());
  Configuration configuration = configurationOf(request, axes, choice);
  configuration.choice.clear();
  configuration.settings.insert(configuration.settings.end(), request.reference_settings.begin(),
                                request.reference_settings.end());
  return configuration;
}

std::size_t indexOf(const std::vector<Axis>& axes, const std::vector<std::size_t>& choice) {
  std::size_t index = 0;
  for (std::size_t a = 0; a < axes.size(); ++a) index = index * axes[a].size() + choice[a];
  return index;
}

std::string nameOf(const std::vector<Axis>& axes, const Configuration& configuration) {
  if (configuration.isExtraReference()) return "reference";
  std::string text;
  for (std::size_t a = 0; a < axes.size(); ++a)
    text += (a == 0 ? "" : ", ") + axes[a].settingText(configuration.choice[a]);
  return text;
}

std::vector<std::string> runArguments(const SweepRequest& request, const Configuration& configuration) {
  std::vector<std::string> arguments{"run", request.scene};
  const auto add = [&](const char* option, const std::string& value) {
    arguments.emplace_back(option), arguments.push_back(value);
  };
  if (request.until)
    add("--until", printReal(*request.until));
  else if (request.steps)
    add("-n", std::to_string(*request.steps));
  add("--threads", std::to_string(configuration.threads));
  for (const std::string& module : request.modules) add("--module", module);
  for (const std::string& setting : configuration.settings) add("--set", setting);
  return arguments;
}

std::string commandLine(const SweepRequest& request, const Configuration& configuration) {
  std::string line = "stroma";
  for (const std::string& argument : runArguments(request, configuration)) line += " " + quoted(argument);
  return line;
}

std::string commandLine(const SweepRequest& request) {
  std::string line = "stroma sweep";
  for (const std::string& word : request.words) line += " " + quoted(word);
  return line;
}

std::string quoted(const std::string& word) {
  const auto isPlain = [](unsigned char c) {
    return std::isalnum(c) || std::string_view("_-./=+:,@%").find(char(c)) != std::string_view::npos;
  };
  bool is_plain = !word.empty();
  for (const char c : word) is_plain = is_plain && isPlain(static_cast<unsigned char>(c));
  if (is_plain) return word;
  std::string text = "'";
  for (const char c : word) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return text + "'";
}

}  // namespace stroma::sweep
