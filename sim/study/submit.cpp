// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/study/submit.h"

#include <fmt/core.h>

#include <cctype>
#include <cstdio>

#include "sim/base/text.h"

namespace reamsim {

namespace {

constexpr const char* kMark = "Written by reamsim sweep submit";

/// Between the signal and the time limit: time to save checkpoints.
constexpr int kBeforeLimit_s = 60;

// The scripts. What filled() replaces stands in angle brackets.

/// `run_shard I` and `collect`.
constexpr std::string_view kShellFunctions = R"sh(program=<program>
study=<study>
output=<output>
# A job takes one processor, also on a machine with more.
export POCL_MAX_PTHREAD_COUNT=1 POCL_AFFINITY=0
run_shard() { exec "$program" sweep run "$study" -o "$output" --shard "$1/<shards>" --jobs <jobs><settings>; }
collect() { "$program" sweep collect "$study" -o "$output"<settings>; }
)sh";

constexpr std::string_view kSlurmArray = R"sh(#!/bin/bash
# <mark>: an array task per shard.
#SBATCH --job-name=<name>
#SBATCH --array=1-<shards>
#SBATCH --ntasks=1 --cpus-per-task=<jobs>
#SBATCH --time=<time limit>
#SBATCH --signal=B:USR1@<before limit>
#SBATCH --requeue --open-mode=append

<functions>
shard=  # the signal may come at once; without a trap it would end this script
trap 'signalled=yes; if [ -n "$shard" ]; then kill -USR1 "$shard"; fi' USR1
run_shard "$SLURM_ARRAY_TASK_ID" & shard=$!
signalled=yes
while [ -n "$signalled" ]; do  # a signal ends `wait` early
  signalled=
  wait "$shard"; status=$?
done
# 75: checkpoints are saved, the same command continues. 138: the signal came before the program was ready.
if [ "$status" -eq 75 ] || [ "$status" -eq 138 ]; then scontrol requeue "${SLURM_ARRAY_JOB_ID}_$SLURM_ARRAY_TASK_ID"; fi
exit "$status"
)sh";

constexpr std::string_view kSlurmCollect = R"sh(#!/bin/bash
# <mark>: the table of the study, after its shards.
#SBATCH --job-name=<name>.collect
#SBATCH --ntasks=1 --cpus-per-task=1
#SBATCH --time=<time limit>

<functions>
collect
)sh";

constexpr std::string_view kParallel = R"sh(#!/bin/bash
# <mark>: as many shards at a time as the machine has processors for. Run it again to continue.

<functions>export program study output SHELL=/bin/bash
export -f run_shard

at_a_time=$(($(nproc) / <jobs>))
parallel --jobs "$((at_a_time > 0 ? at_a_time : 1))" run_shard ::: $(seq <shards>)
status=$?
collect
exit "$status"
)sh";

constexpr std::string_view kSnakefile = R"py(# <mark>: a job per shard, then the table.
import shlex

program = <program>
study = [<study>, "-o", <output><settings>]
shards = <shards>

localrules: all, collect

rule all:
    input: "collected"

rule shard:
    output: touch("shards/{shard}.done")
    params: command=shlex.join([program, "sweep", "run", *study, "--jobs", "<jobs>"])
    threads: <jobs>
    resources: time="<time limit>"
    # Saves checkpoints before the time limit and ends with 75; Snakemake then repeats it, and it continues.
    shell:
        "POCL_MAX_PTHREAD_COUNT=1 POCL_AFFINITY=0 timeout --preserve-status -s USR1 <most seconds> "
        "{params.command} --shard {wildcards.shard}/<shards>"

rule collect:
    input: expand("shards/{shard}.done", shard=range(1, shards + 1))
    output: touch("collected")
    params: command=shlex.join([program, "sweep", "collect", *study])
    shell: "{params.command}"
)py";

constexpr std::string_view kSnakemakeProfile =
    R"(# <mark>: `snakemake --profile profile` submits to Slurm.
cluster: "sbatch --parsable --job-name=<name>.{wildcards} --ntasks=1 --cpus-per-task={threads} --time={resources.time}"
cluster-status: "./profile/status.sh"
jobs: <shards>
restart-times: 5
latency-wait: 60
)";

/// Without it Snakemake would wait for ever for a job that was killed.
constexpr std::string_view kSnakemakeStatus = R"sh(#!/bin/sh
# <mark>: tells Snakemake what became of a Slurm job.
case "$(scontrol show job "$1" 2>/dev/null | sed -n 's/.*JobState=\([A-Z_]*\).*/\1/p')" in
  PENDING|CONFIGURING|RUNNING|SUSPENDED|COMPLETING|REQUEUED) echo running ;;
  COMPLETED) echo success ;;
  *) echo failed ;;
esac
)sh";

/// A script of a submission. Names are words of a shell, or of Python.
std::string filled(std::string_view script, const Submission& s, bool python = false) {
  const auto word = python ? python_literal : shell_word;
  std::string settings;
  for (const std::string& text : s.overrides) settings += (python ? ", \"--set\", " : " --set ") + word(text);
  return replace_all(replace_all(script, {{"<functions>", kShellFunctions}}),
                     {{"<mark>", kMark},
                      {"<name>", plain_name(s.name)},
                      {"<program>", word(s.program)},
                      {"<study>", word(s.study)},
                      {"<output>", word(s.output)},
                      {"<settings>", settings},
                      {"<shards>", std::to_string(s.shards)},
                      {"<jobs>", std::to_string(s.jobs)},
                      {"<time limit>", s.time_limit},
                      {"<before limit>", std::to_string(kBeforeLimit_s)},
                      {"<most seconds>", std::to_string(seconds_of_time_limit(s.time_limit) - kBeforeLimit_s)}});
}

}  // namespace

SubmissionScripts submission_scripts(BatchSystem system, const Submission& submission) {
  const std::string name = plain_name(submission.name);
  const auto shell = [&](std::string_view script) { return filled(script, submission); };
  switch (system) {
    case BatchSystem::slurm:
      return {{{name + ".sbatch", shell(kSlurmArray)}, {name + ".collect.sbatch", shell(kSlurmCollect)}},
              {"job=$(sbatch --parsable ./" + name + ".sbatch)",
               "sbatch --dependency=afterany:$job ./" + name + ".collect.sbatch"}};
    case BatchSystem::snakemake:
      return {{{"Snakefile", filled(kSnakefile, submission, true)},
               {"profile/config.yaml", shell(kSnakemakeProfile)},
               {"profile/status.sh", shell(kSnakemakeStatus), true}},
              {"snakemake --profile profile"}};
    case BatchSystem::parallel:
      break;
  }
  return {{{name + ".parallel.sh", shell(kParallel), true}}, {"./" + name + ".parallel.sh"}};
}

bool is_submission_text(const std::string& text) {
  return text.substr(0, 80).find(kMark) != std::string::npos;
}

int seconds_of_time_limit(const std::string& text) {
  int hours = 0, minutes = 0, seconds = 0;
  char rest = 0;
  if (text.find_first_not_of("0123456789:") != std::string::npos) return -1;
  // NOLINTNEXTLINE(cert-err34-c): the widths leave no number that an int cannot hold
  if (std::sscanf(text.c_str(), "%4d:%2d:%2d%c", &hours, &minutes, &seconds, &rest) != 3) return -1;
  if (minutes > 59 || seconds > 59) return -1;
  return (hours * 60 + minutes) * 60 + seconds;
}

std::string plain_name(const std::string& name) {
  std::string out;
  for (const char c : name) {
    const auto byte = static_cast<unsigned char>(c);
    const bool plain = byte < 128 && (std::isalnum(byte) != 0 || c == '_' || c == '-' || (c == '.' && !out.empty()));
    out += plain ? c : '_';
  }
  if (out.empty() || out[0] == '-') out.insert(0, "_");
  return out;
}

std::string shell_word(const std::string& text) {
  return "'" + replace_all(text, {{"'", "'\\''"}}) + "'";
}

std::string python_literal(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') out += '\\';
    out += byte < 0x20 || byte == 0x7F ? fmt::format("\\x{:02x}", byte) : std::string(1, c);
  }
  return out + "\"";
}

}  // namespace reamsim
