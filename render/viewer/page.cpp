// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/viewer/page.h"

#include <fmt/core.h>
#include <openssl/evp.h>
#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <new>
#include <stdexcept>

#include "sim/base/text.h"
#include "sim/scenario/show.h"
#include "sim/study/study_folder.h"

namespace reamsim {
namespace embedded {
extern const char* const scene_script;
}

std::string escape_html(std::string_view text) {
  return replace_all(text, {{"&", "&amp;"}, {"<", "&lt;"}, {">", "&gt;"}, {"\"", "&quot;"}, {"'", "&#39;"}});
}

std::string base64(std::span<const std::uint8_t> bytes) {
  std::string out(4 * ((bytes.size() + 2) / 3), '\0');
  // OpenSSL appends a zero, for which a std::string has room, and takes an int length.
  constexpr std::size_t kPiece = 3 << 20;
  for (std::size_t from = 0; from < bytes.size(); from += kPiece) {
    const auto piece = bytes.subspan(from, std::min(kPiece, bytes.size() - from));
    EVP_EncodeBlock(reinterpret_cast<unsigned char*>(out.data() + from / 3 * 4), piece.data(),
                    static_cast<int>(piece.size()));
  }
  return out;
}

std::string compressed_base64(std::span<const std::uint8_t> bytes) {
  constexpr int kLevel = 3;  // of 9: a third of the time of zlib's default of 6, and a page that is 2 % larger
  uLongf size = compressBound(static_cast<uLong>(bytes.size()));
  std::vector<std::uint8_t> packed(size);
  if (compress2(packed.data(), &size, bytes.data(), static_cast<uLong>(bytes.size()), kLevel) != Z_OK) {
    throw std::bad_alloc();  // the room suffices, so memory is all that can be missing
  }
  return base64({packed.data(), size});
}

std::string json_for_script(const nlohmann::ordered_json& json) {
  // In JSON "<" occurs only in strings, where an escape may replace it.
  const std::string text = json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
  return replace_all(text, {{"<", "\\u003c"}});
}

double short_number(double value) {
  return std::strtod(fmt::format("{:.6g}", value).c_str(), nullptr);
}

std::string fill_template(std::string_view page, const PageTexts& texts) {
  std::string out;
  for (std::size_t at = 0;;) {
    const std::size_t open = page.find("{{", at);
    out += page.substr(at, open == std::string_view::npos ? open : open - at);
    if (open == std::string_view::npos) return out;
    const std::size_t close = page.find("}}", open);
    const std::string name(page.substr(open + 2, close - open - 2));
    const auto text = texts.find(name);
    if (close == std::string_view::npos || text == texts.end()) {
      throw std::logic_error("report page: nothing to put in for " + name);
    }
    out += text->second;
    at = close + 2;
  }
}

std::string self_contained_page(const char* page, const std::string& title, const std::string& program,
                                const nlohmann::ordered_json& data, PageTexts texts) {
  texts["title"] = escape_html(title);
  texts["program"] = escape_html(program);
  texts["scene"] = embedded::scene_script;
  texts["data"] = json_for_script(data);
  return fill_template(page, texts);
}

// --- the page of a study

namespace {

using Json = nlohmann::ordered_json;

/// A number with more values than this is no list of levels (as in reamsim.lab.effects).
constexpr std::size_t kMostNumericLevels = 8;

/// Numbers of 32 bits as four planes of bytes, least significant first, which compress better than whole numbers.
std::string packed(std::span<const std::uint32_t> words) {
  std::vector<std::uint8_t> bytes(4 * words.size());
  for (std::size_t i = 0; i < words.size(); ++i) {
    for (std::size_t plane = 0; plane < 4; ++plane) {
      bytes[plane * words.size() + i] = static_cast<std::uint8_t>(words[i] >> (8 * plane));
    }
  }
  return compressed_base64(bytes);
}

std::string packed(const std::vector<double>& numbers) {
  std::vector<std::uint32_t> words;
  for (const double number : numbers) words.push_back(std::bit_cast<std::uint32_t>(static_cast<float>(number)));
  return packed(words);
}

std::string packed(const std::string& text) {
  return compressed_base64({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
}

/// Different texts in the order of their first use.
class TextList {
 public:
  std::uint32_t add(const std::string& text) {
    const auto [found, is_new] = places_.emplace(text, static_cast<std::uint32_t>(texts_.size()));
    if (is_new) texts_.push_back(printable(text));
    return found->second;
  }
  [[nodiscard]] const std::vector<std::string>& texts() const { return texts_; }

 private:
  std::map<std::string, std::uint32_t> places_;
  std::vector<std::string> texts_;
};

class PageData {
 public:
  PageData(const std::string& study, const RunTable& table, std::size_t most_runs) {
    const std::vector<bool> taken = runs_of_table(table.runs.size(), most_runs);
    for (std::size_t i = 0; i < taken.size(); ++i) {
      if (taken[i]) runs_.push_back(&table.runs[i]);
    }
    json_ = {{"study", printable(study)}, {"all", table.all}, {"runs", runs_.size()}, {"constants", Json::array()}};
    add_runs();
    const std::vector<ColumnName> parameters = column_names(table.parameters), results = column_names(table.results);
    for (std::size_t p = 0; p < parameters.size(); ++p) add_parameter(parameters[p], p);
    for (std::size_t r = 0; r < results.size(); ++r) add_result(results[r], r);
    for (const ColumnName& name : headline_results()) json_["headline"].push_back(name.key);
  }

  [[nodiscard]] const Json& json() const { return json_; }

 private:
  void add_runs() {
    std::vector<std::uint32_t> numbers, states, reports, messages;
    std::string ids;
    TextList texts;
    for (const CollectedRun* run : runs_) {
      numbers.push_back(static_cast<std::uint32_t>(run->number));
      states.push_back(static_cast<std::uint32_t>(run->state));
      reports.push_back(run->has_report ? 1 : 0);
      messages.push_back(texts.add(run->message));
      ids += run->id + "\n";
    }
    json_["numbers"] = packed(numbers);
    json_["states"] = packed(states);
    json_["reports"] = packed(reports);
    json_["ids"] = packed(ids);
    json_["messages"] = {{"texts", texts.texts()}, {"data", packed(messages)}};
  }

  static Json column(const ColumnName& name) {
    return {{"key", printable(name.key)}, {"text", printable(name.text)}, {"unit", name.unit}};
  }

  void add_constant(const ColumnName& name, const std::string& value) {
    Json json = column(name);
    json["value"] = printable(value);
    json_["constants"].push_back(std::move(json));
  }

  void add_parameter(const ColumnName& name, std::size_t place) {
    TextList texts;
    std::vector<std::uint32_t> levels;
    std::vector<double> numbers;
    for (const CollectedRun* run : runs_) {
      const std::string& cell = run->cells[place];
      levels.push_back(texts.add(cell));
      const auto number = parse_number(cell);
      if (number && std::isfinite(*number)) numbers.push_back(*number);
    }
    const bool is_number = numbers.size() == runs_.size();
    if (texts.texts().size() < 2) return add_constant(name, texts.texts().empty() ? "" : texts.texts()[0]);
    Json json = column(name);
    json["parameter"] = true;
    if (is_number && texts.texts().size() > kMostNumericLevels) {
      json["data"] = packed(numbers);
    } else {
      std::vector<std::string> shown;
      for (const std::string& text : texts.texts()) shown.push_back(is_number ? text : shown_cell(text));
      json["levels"] = shown;
      json["numeric"] = is_number;
      json["data"] = packed(levels);
    }
    json_["columns"].push_back(std::move(json));
  }

  void add_result(const ColumnName& name, std::size_t place) {
    std::vector<double> numbers;
    double least = std::numeric_limits<double>::infinity(), most = -least;
    bool complete = true;
    for (const CollectedRun* run : runs_) {
      const double number = run->numbers.empty() ? std::numeric_limits<double>::quiet_NaN() : run->numbers[place];
      numbers.push_back(number);
      if (std::isnan(number)) {
        complete = complete && run->state != RunState::done;
        continue;
      }
      least = std::min(least, number);
      most = std::max(most, number);
    }
    if (least > most) return;
    if (least == most && complete) return add_constant(name, rounded_text(least));
    Json json = column(name);
    json["data"] = packed(numbers);
    json_["columns"].push_back(std::move(json));
  }

  std::vector<const CollectedRun*> runs_;
  Json json_;
};

}  // namespace

std::string study_page(const std::string& study, const RunTable& table, std::size_t most_bytes) {
  // Noise does not compress, so the number of runs alone does not bound the size.
  for (std::size_t most_runs = table.runs.size();; most_runs /= 2) {
    const std::string page =
        self_contained_page(embedded::study_page, printable(study), "reamsim sweep " REAMSIM_VERSION,
                            PageData(study, table, most_runs).json());
    if (page.size() <= most_bytes || most_runs <= 1) return page;
  }
}

}  // namespace reamsim
