// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scan/dicom_files.h"

#include <itkGDCMImageIO.h>

#include <algorithm>
#include <set>

#include "sim/base/error.h"
#include "sim/isolation/read_in_child.h"
#include "sim/scan/image_io.h"
#include "sim/scan/quiet.h"

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

/// The headers of all files; those of `damaged` ones are not read.
void put_headers(ResultWriter& out, const std::vector<std::string>& files, const std::vector<std::string>& damaged) {
  for (const std::string& path : files) {
    DicomFile file{DicomKind::damaged, {}};
    if (std::ranges::find(damaged, path) == damaged.end()) {
      out.begin_file(path);
      file.kind = read_dicom_header(path, file.header);
    }
    put_dicom_file(out, file);
  }
}

/// Reads the headers of all files but the `damaged` ones.
std::vector<DicomFile> read_headers_but(const std::set<std::string>& damaged, const std::vector<std::string>& files,
                                        const std::string& folder, const std::string& key) {
  const std::vector<std::string> unread(damaged.begin(), damaged.end());
  ChildResult result = read_in_child<put_headers>({folder, key}, limits_for(files), files, unread);
  std::vector<DicomFile> out(files.size());
  for (DicomFile& file : out) file = take_dicom_file(result.reader());
  return out;
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
    put_geometry(out, geometry_of(*io, path, key, true));
    out.put(pixel_type_of(*io));
  }
}

void put_slices(ResultWriter& out, const std::vector<std::string>& files, const PlainBox& box, const std::string& key) {
  const IndexBox in_slice = box.get();
  const auto pixels = static_cast<std::size_t>(in_slice.voxels());
  float* place = out.array<float>(pixels * files.size());
  for (const std::string& path : files) {
    out.begin_file(path);
    const itk::GDCMImageIO::Pointer io = open_slice(path, key);
    const Vec3i dims = geometry_of(*io, path, key, true).dims;
    if (((in_slice.start + in_slice.size).array() > dims.array()).any()) {
      throw InputError({path}, key, "the slice has changed while it was read", "start again");
    }
    // Each slice has its own rescale slope and intercept, so it has its own reader.
    read_voxels(*io, in_slice, 0, path, key, place);
    place += pixels;
  }
}

}  // namespace

std::vector<DicomFile> read_dicom_headers(const std::vector<std::string>& files, const std::string& folder,
                                          const std::string& key) {
  std::set<std::string> damaged;
  while (true) {
    try {
      return read_headers_but(damaged, files, folder, key);
    } catch (const InputError& error) {
      // A header is at most DicomKind::damaged, so an error names the file on which the child died.
      const std::string& path = error.mistakes().front().where.file;
      if (damaged.size() >= kMostCrashes || !damaged.insert(path).second || !std::ranges::count(files, path)) throw;
    }
  }
}

std::vector<SliceFacts> read_slice_facts(const std::vector<std::string>& files, const std::string& key) {
  if (files.empty()) return {};
  ChildResult result = read_in_child<put_slice_facts>({files.front(), key}, limits_for(files), files, key);
  std::vector<SliceFacts> out(files.size());
  for (SliceFacts& slice : out) {
    slice.geometry = take_geometry(result.reader());
    slice.pixel_type = result.reader().text();
  }
  return out;
}

std::vector<float> read_slices(const std::vector<std::string>& files, const IndexBox& in_slice,
                               const std::string& key) {
  const auto pixels = static_cast<std::size_t>(in_slice.voxels());
  ReadLimits limits = limits_for(files);
  limits.result_bytes += pixels * files.size() * sizeof(float);
  ChildResult result = read_in_child<put_slices>({files.front(), key}, limits, files, PlainBox(in_slice), key);
  std::vector<float> out = result.reader().array<float>();
  if (out.size() != pixels * files.size()) result.reader().fail();
  return out;
}

}  // namespace reamsim::ct
