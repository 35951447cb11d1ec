// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Allocations: operator new, wherever it is called, and malloc() and the like where the program itself, zlib or libpng
// calls them. Eigen is part of the program.
#include <dlfcn.h>
#include <malloc.h>

#include <link.h>
#include <array>
#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <new>

#include "faults.h"

namespace {

using namespace reamsim::test;

struct Range {
  std::uintptr_t begin = 0, end = 0;
};

/// Code of the program, zlib and libpng.
std::array<Range, 16> callers;
std::size_t caller_count = 0;

int add_module(dl_phdr_info* module, std::size_t, void* first) {
  const bool program = *static_cast<int*>(first) == 1;
  *static_cast<int*>(first) = 0;
  const bool listed = std::strstr(module->dlpi_name, "/libz.so") != nullptr ||
                      std::strstr(module->dlpi_name, "/libpng16.so") != nullptr;
  if (!program && !listed) return 0;
  for (int i = 0; i < module->dlpi_phnum; ++i) {
    const ElfW(Phdr)& part = module->dlpi_phdr[i];
    if (part.p_type != PT_LOAD || (part.p_flags & PF_X) == 0 || caller_count == callers.size()) continue;
    const std::uintptr_t begin = module->dlpi_addr + part.p_vaddr;
    callers[caller_count++] = {begin, begin + part.p_memsz};
  }
  return 0;
}

__attribute__((constructor)) void find_callers() {
  int first = 1;
  dl_iterate_phdr(add_module, &first);
}

bool is_caller(const void* address) {
  const auto place = reinterpret_cast<std::uintptr_t>(address);
  for (std::size_t i = 0; i < caller_count; ++i) {
    if (callers[i].begin <= place && place < callers[i].end) return true;
  }
  return false;
}

bool malloc_fails(const char* call, std::size_t bytes, const void* caller) {
  if (!injects(FaultKind::allocation) || !is_large(bytes) || !is_caller(caller)) return false;
  if (!must_fail(FaultKind::allocation, call, "")) return false;
  errno = ENOMEM;
  return true;
}

}  // namespace

extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);

void* malloc(std::size_t bytes) noexcept {
  return malloc_fails("malloc", bytes, __builtin_return_address(0)) ? nullptr : __libc_malloc(bytes);
}
void* calloc(std::size_t count, std::size_t bytes) noexcept {
  return malloc_fails("calloc", count * bytes, __builtin_return_address(0)) ? nullptr : __libc_calloc(count, bytes);
}
void* realloc(void* old, std::size_t bytes) noexcept {
  return malloc_fails("realloc", bytes, __builtin_return_address(0)) ? nullptr : __libc_realloc(old, bytes);
}
}

namespace {

void* allocate(std::size_t bytes, std::size_t alignment) noexcept {
  if (injects(FaultKind::allocation) && is_large(bytes) && must_fail(FaultKind::allocation, "operator new", "")) {
    return nullptr;
  }
  const std::size_t some = bytes == 0 ? 1 : bytes;
  return alignment == 0 ? __libc_malloc(some) : __libc_memalign(alignment, some);
}

void* allocate_or_throw(std::size_t bytes, std::size_t alignment) {
  void* out = allocate(bytes, alignment);
  if (out == nullptr) throw std::bad_alloc();
  return out;
}

}  // namespace

void* operator new(std::size_t bytes) {
  return allocate_or_throw(bytes, 0);
}
void* operator new[](std::size_t bytes) {
  return allocate_or_throw(bytes, 0);
}
void* operator new(std::size_t bytes, const std::nothrow_t&) noexcept {
  return allocate(bytes, 0);
}
void* operator new[](std::size_t bytes, const std::nothrow_t&) noexcept {
  return allocate(bytes, 0);
}
void* operator new(std::size_t bytes, std::align_val_t alignment) {
  return allocate_or_throw(bytes, static_cast<std::size_t>(alignment));
}
void* operator new[](std::size_t bytes, std::align_val_t alignment) {
  return allocate_or_throw(bytes, static_cast<std::size_t>(alignment));
}
void operator delete(void* place) noexcept {
  std::free(place);
}
void operator delete[](void* place) noexcept {
  std::free(place);
}
void operator delete(void* place, std::size_t) noexcept {
  std::free(place);
}
void operator delete[](void* place, std::size_t) noexcept {
  std::free(place);
}
void operator delete(void* place, std::align_val_t) noexcept {
  std::free(place);
}
void operator delete[](void* place, std::align_val_t) noexcept {
  std::free(place);
}
void operator delete(void* place, std::size_t, std::align_val_t) noexcept {
  std::free(place);
}
void operator delete[](void* place, std::size_t, std::align_val_t) noexcept {
  std::free(place);
}
