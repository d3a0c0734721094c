// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/scene/archive.h"

#include <fmt/format.h>

#include <stdexcept>

namespace stroma {

Archive::Archive(std::map<std::string, Entry> entries) : entries_(std::move(entries)), reading_(true) {}
Archive Archive::readable() const { return Archive(entries_); }

Archive::Entry& Archive::find(std::string_view name, Kind kind) {
  const auto found = entries_.find(fullName(name));
  if (found == entries_.end())
    throw std::runtime_error(
        fmt::format("the checkpoint has no '{}' of {}: it was written by another scene, or with other settings", name, owner_));
  if (found->second.kind != kind) throw std::runtime_error(fmt::format("'{}' of {} has another type in the checkpoint", name, owner_));
  found->second.is_read = true;
  return found->second;
}

std::size_t Archive::count(std::string_view name, Kind kind, std::size_t present) {
  return reading_ ? find(name, kind).bytes.size() / 8 : present;
}

void Archive::numbers(std::string_view name, Kind kind, void* values, std::size_t count) {
  if (!reading_) {
    Entry entry{kind, std::string(static_cast<const char*>(values), 8 * count), false};
    if (!entries_.emplace(fullName(name), std::move(entry)).second)
      throw std::logic_error(fmt::format("{} writes '{}' twice into a checkpoint", owner_, name));
    return;
  }
  const Entry& entry = find(name, kind);
  if (entry.bytes.size() != 8 * count)
    throw std::runtime_error(
        fmt::format("the checkpoint holds {} numbers of '{}' of {}, where the scene has {}: it was written by another "
                    "scene, or with other settings",
                    entry.bytes.size() / 8, name, owner_, count));
  if (count > 0) std::memcpy(values, entry.bytes.data(), entry.bytes.size());
}

void Archive::value(std::string_view name, std::string& text) {
  if (reading_)
    text = find(name, Kind::text).bytes;
  else
    entries_.emplace(fullName(name), Entry{Kind::text, text, false});
}

Archive Archive::take(const std::string& owner) {
  std::map<std::string, Entry> taken;
  const std::string prefix = owner + ":";
  for (auto entry = entries_.lower_bound(prefix); entry != entries_.end() && entry->first.starts_with(prefix);)
    taken.insert(entries_.extract(entry++));
  Archive archive(std::move(taken));
  archive.enter(owner);
  return archive;
}

void Archive::checkAllRead() const {
  for (const auto& [name, entry] : entries_)
    if (!entry.is_read)
      throw std::runtime_error(
          fmt::format("the checkpoint has {}, which the scene does not: it was written by another scene, or with other settings",
                      name));
}

}  // namespace stroma
