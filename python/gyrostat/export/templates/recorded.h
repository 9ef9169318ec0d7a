/* SPDX-License-Identifier: MIT */
/* Rows of recorded.csv, and how far the outputs of a stack are from them. C99 and C++. */
#ifndef RECORDED_H
#define RECORDED_H
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* First column of each signal. */
enum {
@offsets@
  recorded_columns = @columns@
};

/* Rows that a float stack is held to. Played back without a plant, its rounding feeds on itself: an observer takes what the
   rounded command did not do for a disturbance, and the law passes that on. */
enum { recorded_float_rows = @float_rows@ };

typedef struct {
  int exact;                    /* double: every number within 1e-12; float: see verdict */
  double row[recorded_columns]; /* the present one */
  long rows, wrong;             /* rows held against the record; numbers that were not finite */
  double worst;                 /* largest |now - recorded| / max(1, |recorded|) */
  const char* worst_name;
  double square[recorded_columns];  /* sum of (now - recorded)^2 over the first rows */
  double largest[recorded_columns]; /* |recorded| in them */
  const char* name[recorded_columns];
} deviation;

static FILE* open_recording(const char* path) {
  char line[32 * recorded_columns + 64];
  FILE* file = fopen(path, "r");
  if (file == NULL || fgets(line, sizeof line, file) == NULL) {
    fprintf(stderr, "%s: cannot be read\n", path);
    if (file != NULL) fclose(file);
    return NULL;
  }
  return file;
}

/* 1: a row was read. */
static int next_row(FILE* file, double* row) {
  char line[32 * recorded_columns + 64];
  char* at = line;
  int i;
  if (fgets(line, sizeof line, file) == NULL) return 0;
  for (i = 0; i < recorded_columns; ++i) {
    char* end;
    row[i] = strtod(at, &end);
    if (end == at) return 0;
    at = end + 1;
  }
  return 1;
}

static void hold_against_record(deviation* d, const char* name, int column, double now) {
  const double recorded = d->row[column], size = fabs(recorded);
  const double off = now == recorded ? 0.0 : fabs(now - recorded); /* infinite on both sides is equal */
  if (column == allocation_u) ++d->rows;
  if (!(off <= HUGE_VAL) || (off == HUGE_VAL && d->exact)) ++d->wrong;
  if (off / fmax(1.0, size) > d->worst || d->worst_name == NULL) {
    d->worst = off / fmax(1.0, size);
    d->worst_name = name;
  }
  if (d->rows > recorded_float_rows) return;
  d->name[column] = name;
  d->square[column] += off * off;
  if (size > d->largest[column]) d->largest[column] = size;
}

/* Closes the file. 0: the stack does what was recorded. Exact: every number within 1e-12, of itself where it is larger than
   1. In float: each signal within @float_tolerance@ of its largest value, root mean square over the first rows; then finite. */
static int verdict(deviation* d, FILE* file) {
  const int complete = feof(file);
  double worst = 0.0;
  const char* name = "nothing";
  int i, j;
  fclose(file);
  if (d->rows < 2 || !complete) {
    printf("recorded.csv: only %ld rows could be read\n", d->rows);
    return 2;
  }
  if (d->wrong > 0) {
    printf("%ld samples, %ld numbers that are not finite\n", d->rows, d->wrong);
    return 1;
  }
  if (d->exact) {
    printf("%ld samples, largest deviation %.2e (%s), allowed 1e-12\n", d->rows, d->worst, d->worst_name);
    return d->worst <= 1e-12 ? 0 : 1;
  }
  for (i = 0; i < recorded_columns; ++i) {
    const long first = recorded_float_rows, rows = d->rows < first ? d->rows : first;
    double scale = 0.0, rms;
    if (d->name[i] == NULL) continue;
    for (j = 0; j < recorded_columns; ++j) /* all elements of a signal have one scale */
      if (d->name[j] != NULL && strcmp(d->name[i], d->name[j]) == 0) scale = fmax(scale, d->largest[j]);
    rms = sqrt(d->square[i] / (double)rows) / (scale > 0.0 ? scale : 1.0);
    if (rms > worst) {
      worst = rms;
      name = d->name[i];
    }
  }
  printf("%ld samples in float, deviation of the first %d: %.2e of the signal (%s), allowed @float_tolerance@\n", d->rows,
         (int)recorded_float_rows, worst, name);
  return worst <= @float_tolerance@ ? 0 : 1;
}

/* Copies n numbers of the present row. */
#define take_recorded(row, column, to, n) \
  do {                                    \
    int recorded_i;                       \
    for (recorded_i = 0; recorded_i < (n); ++recorded_i) (to)[recorded_i] = (row)[(column) + recorded_i]; \
  } while (0)

#endif
