// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// The input is a checkpoint without its CRC-32, which would hide the reader from the fuzzer.
#include "sim/run/checkpoint.h"

#include <zlib.h>

#include <vector>

#include "input_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace reamsim;
  std::vector<std::uint8_t> bytes(data, data + size);
  const auto sum = static_cast<std::uint32_t>(crc32_z(0, data, size));
  const auto* last = reinterpret_cast<const std::uint8_t*>(&sum);
  bytes.insert(bytes.end(), last, last + sizeof sum);
  return test::read_input(bytes.data(), bytes.size(), "checkpoint-0.bin", [](const std::string&) {
    const auto checkpoint = CheckpointFiles(test::input_folder()).read();
    if (!checkpoint) return;
    FillBricks fill(Vec3i(2, 2, 2));
    restore_fill(*checkpoint, fill, test::input_folder() + "/checkpoint-0.bin");
  });
}
