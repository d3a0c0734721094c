// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/stress/record.h"

#include <fstream>

namespace stroma::stress {

using Json = nlohmann::ordered_json;

Record::Record(const std::string& file, const std::string& key) {
  std::string kept = Json{{"key", key}}.dump() + "\n";
  {
    std::ifstream lines(file);
    std::string line;
    if (std::getline(lines, line) && line + "\n" == kept)
      while (std::getline(lines, line)) {
        const Json json = Json::parse(line, nullptr, false);
        try {
          made_[json.at("case").get<long>()] = outcomeFrom(json);
        } catch (const std::exception&) {
          break;  // of a command that was killed while it wrote
        }
        kept += line + "\n";
      }
  }
  makeFolderOf(file);
  writeWholeFile(file, kept);
  file_.open(file);
  file_.keep(kept.size());
}

void Record::add(long number, const Outcome& outcome) {
  made_[number] = outcome;
  Json json{{"case", number}};
  json.update(toJson(outcome));
  file_.append(json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n");
}

}  // namespace stroma::stress
