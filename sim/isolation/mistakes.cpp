// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/isolation/mistakes.h"

#include <utility>
#include <vector>

namespace reamsim {

void put_mistakes(ResultWriter& out, const InputError& error) {
  out.put(std::uint64_t{error.mistakes().size()});
  for (const Mistake& mistake : error.mistakes()) {
    out.put(mistake.where.file);
    out.put(mistake.where.line);
    out.put(mistake.where.column);
    for (const std::string* text : {&mistake.key, &mistake.found, &mistake.expected}) out.put(*text);
  }
}

void throw_mistakes(ResultReader& in) {
  constexpr std::uint64_t kMost = 1000;
  const auto count = in.get<std::uint64_t>();
  if (count == 0 || count > kMost) in.fail();
  std::vector<Mistake> mistakes(count);
  for (Mistake& mistake : mistakes) {
    mistake.where.file = in.text();
    mistake.where.line = in.get<int>();
    mistake.where.column = in.get<int>();
    for (std::string* text : {&mistake.key, &mistake.found, &mistake.expected}) *text = in.text();
  }
  throw InputError(std::move(mistakes));
}

}  // namespace reamsim
