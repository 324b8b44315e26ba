/* SPDX-License-Identifier: MIT
 *
 * The parts of a run's page.
 */
#ifndef RMAP_RUN_REPORT_FACTS_H
#define RMAP_RUN_REPORT_FACTS_H

#include "analysis/report/run_report.h"

/* Facts, tables and remarks; nothing here fails. */
void rmap_run_report_facts(const struct rmap_run_report *report, FILE *out);
void rmap_run_report_warnings(const struct rmap_run_report *report, FILE *out);
void rmap_run_report_provenance(const struct rmap_run_report *report, FILE *out);
void rmap_run_report_scene(const struct rmap_run_report *report, FILE *out);
void rmap_run_report_parts(const struct rmap_run_report *report, FILE *out);
void rmap_run_report_energy(const struct rmap_run_report *report, FILE *out);
void rmap_run_report_paths(const struct rmap_run_report *report, FILE *out);

/* Elements: <td> with a number ("nan" where there is none), with a number and its error, with
 * text; the class n aligns numbers. */
void rmap_run_report_measured(FILE *out, double value, double error);

#endif
