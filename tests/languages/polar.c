/* The Jacobian of (r cos f, r sin f), for `check::Pipe`: reads {"ask":"jacobian","x":[r,f]} line by line. */

#include <math.h>
#include <stdio.h>
#include <string.h>

int main(void) {
    char line[4096];
    while (fgets(line, sizeof line, stdin)) {
        double r, f;
        const char *x = strstr(line, "\"x\":[");
        if (!x || sscanf(x, "\"x\":[%lf,%lf]", &r, &f) != 2) {
            puts("{\"error\":\"no x\"}");
        } else {
            printf("[[%.17g,%.17g],[%.17g,%.17g]]\n", cos(f), -r * sin(f), sin(f), r * cos(f));
        }
        fflush(stdout);
    }
    return 0;
}
