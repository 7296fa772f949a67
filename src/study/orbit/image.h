/* The images of a state: what a motion may have become after a part of its period. Private to src/study.
 *
 * An image multiplies every state by a sign and then adds turns of the angle, of 2 pi / turns each. All that
 * a model declares is here: its symmetries as far as they are such maps, the turn and the mirror image of its
 * angle, and their products. */
#ifndef CNS_STUDY_ORBIT_IMAGE_H
#define CNS_STUDY_ORBIT_IMAGE_H

#include "cns/model.h"

typedef struct cns_image {
    signed char *sign; /* per state */
    long turns;        /* of the angle, after the signs */
    char name[128];    /* as the model has it, "" of the identity */
} cns_image;

typedef struct cns_images {
    const cns_model *model;
    int n; /* item 0 is the identity */
    cns_image *item;
} cns_images;

void cns_images_open(cns_images *s, const cns_model *model);
void cns_images_close(cns_images *s);

/* After how many repetitions of the image every state is back, whole revolutions of the angle apart; turns:
 * those that the motion really makes, any whole number of revolutions more than the image. *winding: so many
 * revolutions. */
int cns_image_order(const cns_images *s, const cns_image *image, long turns, long *winding);

/* Turns in a whole revolution; 1 without an angle. */
int cns_images_turns(const cns_images *s);

#endif
