#include "mpi/blame.hpp"

#include <algorithm>
#include <map>
#include <set>

namespace carillon::mpi {

namespace {

using Evidence = Blame::Evidence;

Blame blame(const Testimony& told, Evidence evidence, const std::string& words) {
  return {evidence, told.process, told.task, told.stage, told.item, words};
}

/// Whether the host of a testimony ran out of memory since its task began.
bool ran_out_of_memory(const Testimony& told, const std::vector<Host>& now) {
  return std::any_of(now.begin(), now.end(),
                     [&](const Host& host) { return oom_kills_between(told.host, host) > 0; });
}

/// The silent one of each host without memory that held most.
std::vector<const Testimony*> largest_where_memory_ran_out(const std::vector<Testimony>& told,
                                                           const std::vector<Host>& now) {
  std::map<std::string, const Testimony*> by_host;
  for (const Testimony& one : told) {
    if (one.end != Testimony::End::silent || !ran_out_of_memory(one, now)) continue;
    const Testimony*& most = by_host[one.host.name];
    if (most == nullptr || one.resident > most->resident) most = &one;
  }
  std::vector<const Testimony*> largest;
  for (const auto& [name, one] : by_host) largest.push_back(one);
  return largest;
}

}  // namespace

std::vector<Blame> blamed_tasks(const std::vector<Testimony>& told, const std::vector<Host>& now) {
  std::vector<Blame> all;
  for (const Testimony& one : told) {
    if (one.end == Testimony::End::overdue) all.push_back(blame(one, Evidence::overdue, one.words));
    if (one.end == Testimony::End::crashed) all.push_back(blame(one, Evidence::crash, one.words));
  }
  for (const Testimony* one : largest_where_memory_ran_out(told, now)) {
    all.push_back(blame(*one, Evidence::memory, "the machine ran out of memory"));
  }
  // Nothing else explains the end: then it may have been the one process that said nothing.
  const auto is_silent = [](const Testimony& one) { return one.end == Testimony::End::silent; };
  std::set<std::string> silent_tasks;
  for (const Testimony& one : told) {
    if (is_silent(one)) silent_tasks.insert(one.task);
  }
  if (all.empty() && silent_tasks.size() == 1) {
    const auto one = std::find_if(told.begin(), told.end(), is_silent);
    all.push_back(blame(*one, Evidence::silence, "its process was killed or left"));
  }
  // The ranks of a group fall together.
  std::vector<Blame> once;
  std::set<std::string> seen;
  for (Blame& one : all) {
    if (seen.insert(one.task).second) once.push_back(std::move(one));
  }
  return once;
}

std::string name_of(Blame::Evidence evidence) {
  switch (evidence) {
    case Evidence::crash:
      return "crash";
    case Evidence::memory:
      return "memory";
    case Evidence::overdue:
      return "overdue";
    case Evidence::silence:
      break;
  }
  return "silence";
}

}  // namespace carillon::mpi
