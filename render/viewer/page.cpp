// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/viewer/page.h"

#include <fmt/core.h>
#include <meshoptimizer.h>
#include <openssl/evp.h>
#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <new>
#include <stdexcept>
#include <vector>

#include "render/viewer/report_data.h"
#include "sim/base/text.h"
#include "sim/bone/voxmap/voxmap.h"

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
  uLongf size = compressBound(static_cast<uLong>(bytes.size()));
  std::vector<std::uint8_t> packed(size);
  if (compress2(packed.data(), &size, bytes.data(), static_cast<uLong>(bytes.size()), Z_BEST_COMPRESSION) != Z_OK) {
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

namespace {

constexpr std::size_t kVertexBytes = BoneSurface::kStride * sizeof(float);  // of a vertex
constexpr int kNormalSteps = 254, kAttributeSteps = 255;

/// Appends the triangles of `indices` to `out`, simplified to at most `most`.
void simplify(const BoneSurface& surface, const std::vector<std::uint32_t>& indices, std::size_t most,
              std::vector<std::uint32_t>& out) {
  if (indices.size() <= 3 * most) {
    out.insert(out.end(), indices.begin(), indices.end());
    return;
  }
  constexpr float kAnyError = 1;  // only the number of triangles limits
  std::vector<std::uint32_t> kept(indices.size());
  kept.resize(meshopt_simplify(kept.data(), indices.data(), indices.size(), surface.vertices.data(), surface.count(),
                               kVertexBytes, 3 * most, kAnyError, meshopt_SimplifyLockBorder, nullptr));
  out.insert(out.end(), kept.begin(), kept.end());
}

/// Maps 0, −1, 1, −2 … to 0, 1, 2, 3 …
std::uint16_t zigzag(std::uint16_t difference) {
  return static_cast<std::uint16_t>((difference << 1) ^ (difference & 0x8000 ? 0xFFFF : 0));
}

void append_indices(const std::vector<std::uint32_t>& indices, std::vector<std::uint8_t>& out) {
  std::uint32_t next = 0;
  for (const std::uint32_t index : indices) {
    std::uint32_t below = next - index;
    if (below == 0) ++next;
    for (; below > 127; below >>= 7) out.push_back(static_cast<std::uint8_t>(128 | (below & 127)));
    out.push_back(static_cast<std::uint8_t>(below));
  }
}

}  // namespace

BoneSurface simplified(const BoneSurface& surface, const MeshBudget& budget) {
  std::vector<std::uint32_t> unreamed, reamed;
  const auto is_reamed = [&](std::uint32_t vertex) {
    return surface.vertices[vertex * BoneSurface::kStride + BoneSurface::kReamed] > 0;
  };
  for (std::size_t i = 0; i < surface.indices.size(); i += 3) {
    const auto triangle = std::span(surface.indices).subspan(i, 3);
    auto& part = std::ranges::any_of(triangle, is_reamed) ? reamed : unreamed;
    part.insert(part.end(), triangle.begin(), triangle.end());
  }
  BoneSurface out;
  out.deepest_mm = surface.deepest_mm;
  simplify(surface, unreamed, budget.unreamed_triangles, out.indices);
  simplify(surface, reamed, budget.reamed_triangles, out.indices);
  if (out.indices.empty()) return out;
  meshopt_optimizeVertexCache(out.indices.data(), out.indices.data(), out.indices.size(), surface.count());
  out.vertices.resize(surface.vertices.size());
  const std::size_t used = meshopt_optimizeVertexFetch(out.vertices.data(), out.indices.data(), out.indices.size(),
                                                       surface.vertices.data(), surface.count(), kVertexBytes);
  out.vertices.resize(used * BoneSurface::kStride);
  return out;
}

bool counts_as_reamed(const float* vertex) {
  return std::lround(kAttributeSteps * std::clamp(double{vertex[BoneSurface::kReamed]}, 0.0, 1.0)) > 0;
}

void append_numbers16(std::span<const double> values, double low, double size, std::vector<std::uint8_t>& out,
                      int steps) {
  std::vector<std::uint8_t> high;
  std::uint16_t before = 0;
  for (const double value : values) {
    const double fraction = (value - low) / std::max(size, 1e-6);
    const auto now = static_cast<std::uint16_t>(std::lround(steps * std::clamp(fraction, 0.0, 1.0)));
    const std::uint16_t code = zigzag(static_cast<std::uint16_t>(now - before));
    before = now;
    out.push_back(static_cast<std::uint8_t>(code & 255));
    high.push_back(static_cast<std::uint8_t>(code >> 8));
  }
  out.insert(out.end(), high.begin(), high.end());
}

std::vector<std::uint8_t> mesh_bytes(const BoneSurface& surface, const Eigen::AlignedBox3f& box, double depth_max_mm) {
  std::vector<std::uint8_t> out;
  const auto append = [&](std::size_t component, double low, double size, int steps) {
    std::vector<double> values;
    values.reserve(surface.count());
    for (std::size_t i = component; i < surface.vertices.size(); i += BoneSurface::kStride) {
      values.push_back(surface.vertices[i]);
    }
    append_numbers16(values, low, size, out, steps);
  };
  for (std::size_t axis = 0; axis < 3; ++axis) {
    append(axis, box.min()[static_cast<int>(axis)], box.sizes()[static_cast<int>(axis)], kSteps16);
  }
  append(BoneSurface::kDepth, 0, depth_max_mm, kSteps16);
  for (std::size_t axis = 0; axis < 3; ++axis) append(BoneSurface::kNormal + axis, -1, 2, kNormalSteps);
  append(BoneSurface::kReamed, 0, 1, kAttributeSteps);
  append(BoneSurface::kDensity, 0, DensityMapping::kMaxDensity_g_cm3, kAttributeSteps);
  append(BoneSurface::kAccessibility, 0, 1, kAttributeSteps);
  append_indices(surface.indices, out);
  return out;
}

nlohmann::ordered_json mesh_json(const BoneSurface& surface, const Eigen::AlignedBox3f& box, double depth_max_mm) {
  return {{"vertices", surface.count()},
          {"triangles", surface.indices.size() / 3},
          {"bytes", compressed_base64(mesh_bytes(surface, box, depth_max_mm))}};
}

Eigen::AlignedBox3f bounds_of(const BoneSurface& surface) {
  Eigen::AlignedBox3f box;
  for (std::size_t i = 0; i < surface.count(); ++i) box.extend(surface.position_mm(i));
  return box;
}

}  // namespace reamsim
