// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>
#include <vector>

namespace reamsim {

/// The program that queues, repeats and accounts for the shards of a study.
enum class BatchSystem { slurm, snakemake, parallel };

/// A study that others will run, in shards of `jobs` processes with one processor each.
struct Submission {
  std::string name;                    ///< of the study
  std::string program;                 ///< reamsim, absolute
  std::string study;                   ///< absolute
  std::string output;                  ///< folder of the study, absolute
  std::vector<std::string> overrides;  ///< of --set
  int shards = 1;
  int jobs = 1;
  std::string time_limit;  ///< HH:MM:SS, of a shard
};

struct SubmissionFile {
  std::string path;  ///< relative
  std::string text;
  bool executable = false;
};

struct SubmissionScripts {
  std::vector<SubmissionFile> files;  ///< the one to start first
  std::vector<std::string> start;     ///< how a person starts them from their folder, a command per line
};

SubmissionScripts submission_scripts(BatchSystem system, const Submission& submission);

bool is_submission_text(const std::string& text);

/// Seconds of HH:MM:SS; −1 where the text is none.
int seconds_of_time_limit(const std::string& text);

/// A name of letters, digits, '.', '_' and '-', for file and job names: what else there is becomes '_'.
std::string plain_name(const std::string& name);

/// A word of a POSIX shell with exactly these bytes.
std::string shell_word(const std::string& text);

std::string python_literal(const std::string& text);

}  // namespace reamsim
