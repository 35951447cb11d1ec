// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Calls that change files. libstdc++ writes through open, fopen, write, writev, close and fclose; libpng through
// fwrite.
#include <fcntl.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <unistd.h>

#include <cerrno>
#include <cstdarg>
#include <cstdio>
#include <cstring>

#include "faults.h"

namespace {

using namespace reamsim::test;

template <class Call>
Call next(const char* name, Call) {
  return reinterpret_cast<Call>(next_symbol(name));
}

bool path_fails(FaultKind kind, const char* call, const char* path, bool* half = nullptr) {
  if (!injects(kind) || path == nullptr || !is_watched(path) || !must_fail(kind, call, path, half)) return false;
  errno = fault_error();
  return true;
}

bool file_fails(const char* call, int file, bool* half = nullptr) {
  const int before = errno;
  const bool out = injects(FaultKind::write) && path_fails(FaultKind::write, call, path_of(file), half);
  if (!out) errno = before;
  return out;
}

bool writes(int flags) {
  return (flags & O_ACCMODE) != O_RDONLY || (flags & O_CREAT) != 0;
}

bool was_opened_for_writing(int file) {
  const int flags = fcntl(file, F_GETFL);
  return flags >= 0 && (flags & O_ACCMODE) != O_RDONLY;
}

mode_t mode_in(int flags, va_list arguments) {
  return (flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(arguments, mode_t) : 0;
}

/// The stream has the error that a failed write leaves.
void set_error(std::FILE* stream) {
  stream->_flags |= 0x20;  // _IO_ERR_SEEN of glibc
}

}  // namespace

// The function `name` with the same arguments, unless `fails`.
#define REAMSIM_NEXT(name) static const auto real = next(#name, &(name))

extern "C" {

int open(const char* path, int flags, ...) {
  REAMSIM_NEXT(open);
  va_list arguments;
  va_start(arguments, flags);
  const mode_t mode = mode_in(flags, arguments);
  va_end(arguments);
  return writes(flags) && path_fails(FaultKind::write, "open", path) ? -1 : real(path, flags, mode);
}

int open64(const char* path, int flags, ...) {
  REAMSIM_NEXT(open64);
  va_list arguments;
  va_start(arguments, flags);
  const mode_t mode = mode_in(flags, arguments);
  va_end(arguments);
  return writes(flags) && path_fails(FaultKind::write, "open", path) ? -1 : real(path, flags, mode);
}

std::FILE* fopen(const char* path, const char* mode) {
  REAMSIM_NEXT(fopen);
  const bool reads = mode[0] == 'r' && std::strchr(mode, '+') == nullptr;
  return !reads && path_fails(FaultKind::write, "fopen", path) ? nullptr : real(path, mode);
}

std::FILE* fopen64(const char* path, const char* mode) {
  REAMSIM_NEXT(fopen64);
  const bool reads = mode[0] == 'r' && std::strchr(mode, '+') == nullptr;
  return !reads && path_fails(FaultKind::write, "fopen", path) ? nullptr : real(path, mode);
}

ssize_t write(int file, const void* bytes, size_t count) {
  REAMSIM_NEXT(write);
  bool half = false;
  if (!file_fails("write", file, &half)) return real(file, bytes, count);
  return half && count > 1 ? real(file, bytes, count / 2) : -1;
}

ssize_t writev(int file, const iovec* parts, int count) {
  REAMSIM_NEXT(writev);
  bool half = false;
  if (!file_fails("writev", file, &half)) return real(file, parts, count);
  return half && count > 1 ? real(file, parts, count / 2) : -1;
}

ssize_t pwrite(int file, const void* bytes, size_t count, off_t place) {
  REAMSIM_NEXT(pwrite);
  return file_fails("pwrite", file) ? -1 : real(file, bytes, count, place);
}

size_t fwrite(const void* bytes, size_t size, size_t count, std::FILE* stream) {
  REAMSIM_NEXT(fwrite);
  if (!file_fails("fwrite", fileno(stream))) return real(bytes, size, count, stream);
  set_error(stream);
  return 0;
}

int fflush(std::FILE* stream) {
  REAMSIM_NEXT(fflush);
  if (stream == nullptr || !file_fails("fflush", fileno(stream))) return real(stream);
  set_error(stream);
  return EOF;
}

int fclose(std::FILE* stream) {
  REAMSIM_NEXT(fclose);
  const bool fails = was_opened_for_writing(fileno(stream)) && file_fails("fclose", fileno(stream));
  const int out = real(stream);
  if (!fails) return out;
  errno = fault_error();
  return EOF;
}

int close(int file) {
  REAMSIM_NEXT(close);
  const bool fails = injects(FaultKind::write) && was_opened_for_writing(file) && file_fails("close", file);
  const int out = real(file);
  if (!fails) return out;
  errno = fault_error();
  return -1;
}

int fsync(int file) {
  REAMSIM_NEXT(fsync);
  return file_fails("fsync", file) ? -1 : real(file);
}

int fdatasync(int file) {
  REAMSIM_NEXT(fdatasync);
  return file_fails("fdatasync", file) ? -1 : real(file);
}

int ftruncate(int file, off_t length) noexcept {
  REAMSIM_NEXT(ftruncate);
  return file_fails("ftruncate", file) ? -1 : real(file, length);
}

int truncate(const char* path, off_t length) noexcept {
  REAMSIM_NEXT(truncate);
  return path_fails(FaultKind::write, "truncate", path) ? -1 : real(path, length);
}

int mkdir(const char* path, mode_t mode) noexcept {
  REAMSIM_NEXT(mkdir);
  return path_fails(FaultKind::write, "mkdir", path) ? -1 : real(path, mode);
}

int rename(const char* from, const char* to) noexcept {
  REAMSIM_NEXT(rename);
  return path_fails(FaultKind::rename, "rename", to) ? -1 : real(from, to);
}

int renameat2(int from_folder, const char* from, int to_folder, const char* to, unsigned flags) noexcept {
  REAMSIM_NEXT(renameat2);
  if (flags != 0 && refuses_exchange()) {
    errno = EINVAL;
    return -1;
  }
  return path_fails(FaultKind::rename, "renameat2", to) ? -1 : real(from_folder, from, to_folder, to, flags);
}

int unlink(const char* path) noexcept {
  REAMSIM_NEXT(unlink);
  return path_fails(FaultKind::rename, "unlink", path) ? -1 : real(path);
}

int rmdir(const char* path) noexcept {
  REAMSIM_NEXT(rmdir);
  return path_fails(FaultKind::rename, "rmdir", path) ? -1 : real(path);
}

int remove(const char* path) noexcept {
  REAMSIM_NEXT(remove);
  return path_fails(FaultKind::rename, "remove", path) ? -1 : real(path);
}

}  // extern "C"
