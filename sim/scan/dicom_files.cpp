// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scan/dicom_files.h"

#include <fmt/core.h>
#include <itkGDCMImageIO.h>
#include <algorithm>
#include <cstdint>
#include <memory>
#include <set>

#include "sim/base/error.h"
#include "sim/base/file.h"
#include "sim/isolation/read_in_child.h"
#include "sim/scan/dicom_values.h"
#include "sim/scan/image_io.h"

namespace reamsim::ct {

namespace {

/// Files that may crash the reader before the folder is refused.
constexpr std::size_t kMostCrashes = 20;

ReadLimits limits_for(const std::vector<std::string>& files) {
  std::uint64_t largest = 0;
  for (const std::string& file : files) largest = std::max(largest, bytes_of_file(file));
  constexpr std::uint64_t kResultPerFile = 1 << 16;
  ReadLimits limits = ReadLimits().with(largest, 2 * largest);
  limits.result_bytes += kResultPerFile * files.size();
  limits.files = static_cast<int>(files.size());
  return limits;
}

/// What headers may take: those of a large multi-frame file are many.
constexpr std::uint64_t kHeadersPerFileByte = 4;

ReadLimits limits_for_headers(const std::vector<std::string>& files) {
  ReadLimits limits = limits_for(files);
  for (const std::string& file : files) {
    limits.result_bytes += std::min<std::uint64_t>(kHeadersPerFileByte * bytes_of_file(file), std::uint64_t{64} << 20);
  }
  return limits;
}

/// The headers of all files; those of `damaged` ones are not read.
void put_headers(ResultWriter& out, const std::vector<std::string>& files, const std::vector<std::string>& damaged) {
  for (const std::string& path : files) {
    DicomFile file{DicomKind::damaged, "", {}};
    if (std::ranges::find(damaged, path) == damaged.end()) {
      out.begin_file(path);
      file = read_dicom_header(path);
    }
    out.put(file);
  }
}

itk::GDCMImageIO::Pointer open_slice(const std::string& path, const std::string& key) {
  auto io = itk::GDCMImageIO::New();
  const QuietLibraries quiet;
  try {
    io->SetFileName(path);
    io->ReadImageInformation();
  } catch (const std::exception&) {
    throw InputError({path}, key, "the slice cannot be read: it is truncated or damaged", "give a complete file");
  }
  if (quiet.reports_missing_voxels()) throw InputError({path}, key, "the slice is truncated", "give a complete file");
  return io;
}

void put_slice_facts(ResultWriter& out, const std::vector<std::string>& files, const std::string& key) {
  for (const std::string& path : files) {
    out.begin_file(path);
    const itk::GDCMImageIO::Pointer io = open_slice(path, key);
    out.put(SliceFacts{geometry_of(*io, path, key, true), pixel_type_of(*io)});
  }
}

/// Pixels of a coding that GDCM should decode and does not: damaged, or a variant.
[[noreturn]] void refuse_coding(const InputError& error, const std::string& path, const std::string& key) {
  const std::string syntax = syntax_in_file(path);
  const std::string name = name_of_syntax(syntax);
  if (name.empty()) throw error;
  throw InputError({path}, key, "the pixels cannot be decoded from " + name + " (" + syntax + ")",
                   "the file is truncated or damaged, or coded in an unusual way: " + how_to_decode(name));
}

void put_slice(const std::string& path, const IndexBox& in_slice, const std::string& key, float* place) {
  const itk::GDCMImageIO::Pointer io = open_slice(path, key);
  const Vec3i dims = geometry_of(*io, path, key, true).dims;
  if (((in_slice.start + in_slice.size).array() > dims.array()).any()) {
    throw InputError({path}, key, "the slice has changed while it was read", "start again");
  }
  // Each slice has its own rescale slope and intercept, so it has its own reader.
  try {
    read_voxels(*io, in_slice, 0, path, key, place);
  } catch (const InputError& error) {
    refuse_coding(error, path, key);
  }
}

/// Reads the frames of one file among `slices`.
void put_frames(const std::string& path, const std::vector<SliceSource>& slices, const IndexBox& in_slice,
                const std::string& key, float* first) {
  std::unique_ptr<DicomFrames> decoded;
  try {
    decoded = std::make_unique<DicomFrames>(path, key);
  } catch (const InputError& error) {
    refuse_coding(error, path, key);
  }
  const Vec3i& dims = decoded->dims();
  const Vec3i end = in_slice.start + in_slice.size;
  for (std::size_t n = 0; n < slices.size(); ++n) {
    const SliceSource& slice = slices[n];
    if (slice.path != path) continue;
    if (end.x() > dims.x() || end.y() > dims.y() || slice.frame >= dims.z()) {
      throw InputError({path}, key, fmt::format("the file has {} frames of {}x{} pixels", dims.z(), dims.x(), dims.y()),
                       "its header claims more: give a complete file");
    }
    decoded->copy(slice.frame, in_slice, slice.slope, slice.intercept,
                  first + n * static_cast<std::size_t>(in_slice.voxels()));
  }
}

void put_slices(ResultWriter& out, const std::vector<SliceSource>& slices, const IndexBox& in_slice,
                const std::string& key) {
  const auto pixels = static_cast<std::size_t>(in_slice.voxels());
  float* first = out.array<float>(pixels * slices.size());
  std::set<std::string> multi_frame;
  for (std::size_t n = 0; n < slices.size(); ++n) {
    const std::string& path = slices[n].path;
    const bool is_frame = slices[n].frame >= 0;
    if (is_frame && !multi_frame.insert(path).second) continue;
    out.begin_file(path);
    if (is_frame) {
      put_frames(path, slices, in_slice, key, first);
    } else {
      put_slice(path, in_slice, key, first + n * pixels);
    }
  }
}

/// The geometry of a frame, from its header.
ScanGeometry geometry_of_frame(const DicomHeader& header, const std::string& key) {
  ScanGeometry out;
  if (!header.axes || !header.pixel_spacing_mm || !header.position_mm) {
    throw InputError({header.path}, key,
                     fmt::format("frame {} has no position, orientation or pixel spacing", header.frame + 1),
                     "export the original series");
  }
  out.dims = Vec3i(header.columns, header.rows, 1);
  out.step_mm.col(0) = header.axes->col(0) * header.pixel_spacing_mm->x();
  out.step_mm.col(1) = header.axes->col(1) * header.pixel_spacing_mm->y();
  out.step_mm.col(2) = header.normal() * (header.slice_spacing_mm > 0 ? header.slice_spacing_mm : 1);
  out.origin_mm = *header.position_mm;
  if (!out.is_valid()) {
    throw InputError({header.path}, key, "voxel spacing or axes are degenerate", "export the original series");
  }
  return out;
}

}  // namespace

std::vector<DicomFile> read_dicom_headers(const std::vector<std::string>& files, const std::string& folder,
                                          const std::string& key) {
  std::vector<std::string> damaged;
  while (true) {
    try {
      ChildResult result = read_in_child<put_headers>({folder, key}, limits_for_headers(files), files, damaged);
      std::vector<DicomFile> out(files.size());
      for (DicomFile& file : out) result.reader().read(file);
      return out;
    } catch (const InputError& error) {
      // A header is at most DicomKind::damaged, so an error names the file on which the child died.
      const std::string& path = error.mistakes().front().where.file;
      const bool retried = std::ranges::count(damaged, path) > 0;
      if (damaged.size() >= kMostCrashes || retried || !std::ranges::count(files, path)) throw;
      damaged.push_back(path);
    }
  }
}

bool looks_like_dicom(const std::string& path) {
  const std::string start = read_file_start(path, 132);
  if (start.size() == 132 && start.ends_with("DICM")) return true;
  const bool of_first_group = start.size() >= 4 && (start[0] == 2 || start[0] == 8) && start[1] == 0 && start[3] == 0;
  return of_first_group && start[2] != 0;
}

std::vector<SliceFacts> read_slice_facts(const std::vector<const DicomHeader*>& headers, const std::string& key) {
  std::vector<SliceFacts> out(headers.size());
  std::vector<std::string> files;
  for (std::size_t n = 0; n < headers.size(); ++n) {
    if (headers[n]->frame < 0) {
      files.push_back(headers[n]->path);
    } else {
      out[n] = {geometry_of_frame(*headers[n], key), headers[n]->pixel_type};
    }
  }
  if (files.empty()) return out;
  ChildResult result = read_in_child<put_slice_facts>({files.front(), key}, limits_for(files), files, key);
  for (std::size_t n = 0; n < headers.size(); ++n) {
    if (headers[n]->frame >= 0) continue;
    result.reader().read(out[n]);
  }
  return out;
}

std::vector<float> read_slices(const std::vector<SliceSource>& slices, const IndexBox& in_slice,
                               const std::string& key) {
  const auto pixels = static_cast<std::size_t>(in_slice.voxels());
  std::vector<std::string> files;
  double most_pixels = 0;
  for (const SliceSource& slice : slices) {
    files.push_back(slice.path);
    if (slice.frame >= 0) most_pixels = std::max(most_pixels, slice.file_pixels);
  }
  constexpr double kBytesPerPixel = 12;  // coded, decoded by frame, and decoded as a whole
  ReadLimits limits = limits_for(files).with(0, static_cast<std::uint64_t>(kBytesPerPixel * most_pixels));
  limits.result_bytes += pixels * files.size() * sizeof(float);
  ChildResult result = read_in_child<put_slices>({files.front(), key}, limits, slices, in_slice, key);
  std::vector<float> out = result.reader().array<float>();
  if (out.size() != pixels * files.size()) result.reader().fail();
  return out;
}

}  // namespace reamsim::ct
