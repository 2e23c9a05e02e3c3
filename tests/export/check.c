/* Reads what test it is to run from its argument, and floats from the standard input:
   images: the reference, then frames; writes for each its image and its contacts;
   contacts: images; writes the contacts of each.
   Contacts are a number and ERT_MOST_CONTACTS times five floats. */
#include <stdio.h>

#include "solver.h"

static ErtSolver solver;
static float voltages[ERT_CHANNELS];
static float image[ERT_PIXELS];

static void write_contacts(void) {
  ErtContact contacts[ERT_MOST_CONTACTS] = {{0.0F, 0.0F, 0.0F, 0.0F, 0.0F}};
  const float count = (float)ert_contacts(&solver, image, contacts);
  fwrite(&count, sizeof count, 1, stdout);
  fwrite(contacts, sizeof contacts, 1, stdout);
}

int main(int count, char** words) {
  ert_start(&solver);
  if (count > 1 && words[1][0] == 'c') {
    while (fread(image, sizeof image, 1, stdin) == 1) {
      write_contacts();
    }
    return 0;
  }
  if (fread(voltages, sizeof voltages, 1, stdin) == 1) {
    ert_set_reference(&solver, voltages);
  }
  while (fread(voltages, sizeof voltages, 1, stdin) == 1) {
    ert_image(&solver, voltages, image);
    fwrite(image, sizeof image, 1, stdout);
    write_contacts();
  }
  return 0;
}
