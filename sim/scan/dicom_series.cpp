// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scan/dicom.h"

#include <fmt/core.h>
#include <filesystem>
#include <map>

#include "sim/base/text.h"
#include "sim/scan/dicom_values.h"

namespace reamsim::ct {

namespace {

constexpr const char* kModalityKey = "bone.ct.modality";
/// Spacings that differ by less than this fraction are the same.
constexpr double kSameSpacing = 0.01;

/// Files whose coding GDCM does not have. Skipped with a warning where others are images: a folder may hold videos.
void report_unsupported(const std::vector<std::string>& files, const std::vector<DicomFile>& read, bool has_images,
                        Diagnostics& report) {
  const auto first = std::ranges::find(read, DicomKind::unsupported, &DicomFile::kind);
  if (first == read.end()) return;
  const std::string& path = files[static_cast<std::size_t>(first - read.begin())];
  const auto count = std::ranges::count(read, DicomKind::unsupported, &DicomFile::kind);
  std::string found = "coded as " + first->note + ", which GDCM cannot decode";
  if (count > 1) found += fmt::format(", as {} more files are", count - 1);
  if (!has_images) throw InputError({path}, kScanKey, found, how_to_decode(first->note));
  report.warn(path + ": skipped: " + found + "; " + how_to_decode(first->note));
}

/// Median distance of neighbouring positions along the normal of the first; 0 where unknown.
double slice_distance(const std::vector<DicomHeader>& images) {
  const auto placed = [](const DicomHeader& image) { return image.position_mm.has_value(); };
  if (images.size() < 2 || !images.front().axes || !std::ranges::all_of(images, placed)) return 0;
  std::vector<double> height;
  for (const DicomHeader& image : images) height.push_back(images.front().normal().dot(*image.position_mm));
  std::ranges::sort(height);
  std::vector<double> gap;
  constexpr double kSamePlace_mm = 1e-3;  // of several phases
  for (std::size_t n = 1; n < height.size(); ++n) {
    if (height[n] - height[n - 1] > kSamePlace_mm) gap.push_back(height[n] - height[n - 1]);
  }
  if (gap.empty()) return 0;
  std::ranges::nth_element(gap, gap.begin() + static_cast<std::ptrdiff_t>(gap.size() / 2));
  return gap[gap.size() / 2];
}

DicomSeries series_from(std::vector<DicomHeader> images) {
  const Vec2 pixel = images.front().pixel_spacing_mm.value_or(Vec2::Zero());
  const double distance = slice_distance(images);
  return {std::move(images), Vec3(pixel.x(), pixel.y(), distance)};
}

std::string words_of(const DicomSeries& series) {
  const DicomHeader& first = series.first();
  const Vec3& s = series.spacing_mm;
  std::string out = "UID " + first.series_uid + ", \"" + first.description + "\", " + first.modality + ", ";
  out += std::to_string(series.slices()) + (first.frames > 1 ? " frames" : " slices");
  out += fmt::format(" of {}x{}, {:.4g}x{:.4g}x{:.4g} mm", first.columns, first.rows, s.x(), s.y(), s.z());
  if (!first.kernel.empty()) out += ", kernel " + first.kernel;
  return out;
}

bool same_size(const DicomSeries& a, const DicomSeries& b) {
  return a.slices() == b.slices() &&
         ((a.spacing_mm - b.spacing_mm).cwiseAbs().array() <= kSameSpacing * a.spacing_mm.array()).all();
}

const DicomSeries& named_series(const std::vector<DicomSeries>& all, const std::string& name,
                                const std::string& folder) {
  constexpr std::size_t kMaxDigits = 6;
  const bool is_number = name.size() <= kMaxDigits && is_whole_number(name);
  if (is_number) {
    const std::size_t number = std::stoul(name);
    if (number >= 1 && number <= all.size()) return all[number - 1];
  } else {
    const auto found = std::ranges::find(all, name, [](const DicomSeries& s) { return s.first().series_uid; });
    if (found != all.end()) return *found;
  }
  throw InputError({folder}, kSeriesKey, "no DICOM series '" + name + "'",
                   "expected a UID, or a number from 1 to " + std::to_string(all.size()) + ": " + list_of(all));
}

void check_modality(const DicomSeries& series, bool any_modality, const std::string& folder) {
  if (any_modality || series.first().modality == "CT") return;
  throw InputError({folder}, kModalityKey,
                   "the series is " +
                       (series.first().modality.empty() ? "of unknown modality" : series.first().modality) +
                       ", not CT: " + words_of(series),
                   "choose a CT series, or set bone.ct.modality: any if its values are HU");
}

std::vector<const DicomSeries*> candidates_of(const DicomFolder& found, bool any_modality) {
  std::vector<const DicomSeries*> out;
  for (const DicomSeries& series : found.series) {
    if (any_modality || series.first().modality == "CT") out.push_back(&series);
  }
  const auto is_no_volume = [](const DicomSeries* series) {  // such as a rendering or a screenshot
    const DicomHeader& first = series->first();
    const bool placed = first.position_mm && first.axes && first.pixel_spacing_mm;
    return !first.photometric.starts_with("MONOCHROME") || !(placed || first.frames > 1);
  };
  if (!std::ranges::all_of(out, is_no_volume)) std::erase_if(out, is_no_volume);
  if (out.empty() && found.series.size() == 1) check_modality(found.series.front(), any_modality, found.folder);
  if (out.empty()) {
    throw InputError({found.folder}, kModalityKey,
                     "none of the " + std::to_string(found.series.size()) + " DICOM series is CT",
                     "expected a CT series, or bone.ct.modality: any; found " + list_of(found.series));
  }
  // More slices first, then the finer spacing.
  std::ranges::stable_sort(out, {}, [](const DicomSeries* s) { return std::pair(-s->slices(), s->spacing_mm.prod()); });
  return out;
}

}  // namespace

int DicomSeries::slices() const {
  int out = 0;
  for (const DicomHeader& image : images) out += image.frame >= 0 ? 1 : std::clamp(image.frames, 1, 1'000'000);
  return out;
}

DicomFolder find_dicom_series(const std::string& folder, Diagnostics& report) {
  DicomFolder out;
  out.folder = folder;
  const std::vector<std::string> files = files_below(folder);
  std::vector<DicomFile> read = read_dicom_headers(files, {folder, kScanKey});
  std::map<std::string, std::vector<DicomHeader>> by_uid;
  for (std::size_t n = 0; n < files.size(); ++n) {
    for (DicomHeader& header : read[n].images) by_uid[header.series_uid].push_back(std::move(header));
  }
  const auto add_files_of = [&](DicomKind kind) {
    for (std::size_t n = 0; n < files.size(); ++n) {
      if (read[n].kind == kind) out.unread.push_back(files[n]);
    }
  };
  add_files_of(DicomKind::damaged);
  out.damaged = out.unread;
  add_files_of(DicomKind::unsupported);
  add_files_of(DicomKind::other);
  report_unsupported(files, read, !by_uid.empty(), report);
  if (!out.damaged.empty()) {
    report.warn(folder + ": damaged DICOM files skipped: " + std::to_string(out.damaged.size()) + ", the first is " +
                out.damaged.front());
  }
  for (auto& [uid, images] : by_uid) out.series.push_back(series_from(std::move(images)));
  std::ranges::stable_sort(
      out.series, {}, [](const DicomSeries& s) { return std::tie(s.first().series_number, s.first().series_uid); });
  if (out.series.empty() && !std::filesystem::is_directory(folder)) {
    throw InputError({folder}, kScanKey,
                     out.unread.empty() ? "a DICOM file without an image" : "the DICOM header is truncated or damaged",
                     "expected a folder of DICOM slices, or an NRRD, NIfTI or MetaImage file");
  }
  if (out.series.empty()) {
    throw InputError({folder}, kScanKey,
                     "no DICOM image found in this folder or its subfolders" +
                         (out.damaged.empty() ? "" : " that can be read; damaged: " + out.damaged.front()),
                     "expected a DICOM series");
  }
  return out;
}

std::string list_of(const std::vector<DicomSeries>& series) {
  std::string out;
  for (std::size_t n = 0; n < series.size(); ++n) {
    out += (n == 0 ? "" : "; ") + std::to_string(n + 1) + ": " + words_of(series[n]);
  }
  return out;
}

SeriesChoice parse_series_choice(const std::string& text, const std::string& folder) {
  SeriesChoice out;
  const auto refuse = [&](const std::string& found) {
    throw InputError({folder}, kSeriesKey, "found '" + text + "': " + found,
                     "expected a series, as 2 or its UID; 2/1 for its first volume; or 2#AcquisitionNumber=1");
  };
  const std::size_t mark = std::min(text.find_first_of("/#"), text.size());
  out.series = text.substr(0, mark);
  if (mark == text.size()) return out;
  const std::string rest = text.substr(mark + 1);
  if (text[mark] == '/') {
    constexpr std::size_t kMostDigits = 4;
    if (!is_whole_number(rest) || rest.size() > kMostDigits || std::stoi(rest) < 1) refuse("no number follows '/'");
    out.volume = std::stoi(rest);
    return out;
  }
  for (const std::string& part : split(rest, '#')) {
    const std::size_t equals = part.find('=');
    if (equals == std::string::npos) refuse("'" + part + "' is no TAG=VALUE");
    out.tags.emplace_back(part.substr(0, equals), part.substr(equals + 1));
  }
  return out;
}

const DicomSeries& choose_series(const DicomFolder& found, const SeriesChoice& chosen, bool any_modality,
                                 Diagnostics& report) {
  const std::string& folder = found.folder;
  if (!chosen.series.empty()) {
    const DicomSeries& series = named_series(found.series, chosen.series, folder);
    check_modality(series, any_modality, folder);
    return series;
  }
  const std::vector<const DicomSeries*> candidates = candidates_of(found, any_modality);
  const DicomSeries& best = *candidates.front();
  if (candidates.size() > 1 && same_size(best, *candidates[1])) {
    throw InputError(
        {folder}, kSeriesKey,
        "missing, and two DICOM series have " + std::to_string(best.slices()) + " slices of the same spacing",
        "choose one by its UID or number: " + list_of(found.series));
  }
  if (found.series.size() > 1) {
    const std::string why =
        candidates.size() > 1 ? "; using the one with the most slices (" : "; using the only CT volume (";
    report.warn(folder + ": " + std::to_string(found.series.size()) + " DICOM series" + why +
                std::to_string(best.slices()) + " slices); select another with bone.ct.series");
    report.list("DICOM series, the one in use is " + best.first().series_uid + ": " + list_of(found.series));
  }
  return best;
}

}  // namespace reamsim::ct
