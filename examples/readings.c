/* Prints the resistance of each ok reading: cc -o readings examples/readings.c && ./readings [SOCKET]
 * One line is one JSON object; a program of yours would take a JSON library (jansson, cJSON). */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>

int main(int argc, char **argv)
{
	struct sockaddr_un at = { .sun_family = AF_UNIX };
	char line[65536], *r, *id;
	int fd = socket(AF_UNIX, SOCK_STREAM, 0);

	snprintf(at.sun_path, sizeof at.sun_path, "%s", argc > 1 ? argv[1] : "/run/cermd/cermd.sock");
	if (fd < 0 || connect(fd, (struct sockaddr *)&at, sizeof at) != 0) {
		perror(at.sun_path);
		return 1;
	}
	FILE *in = fdopen(fd, "r");
	while (in && fgets(line, sizeof line, in)) {
		/* A reading without "r_ohm" is open, short or a fault: "status" and "fault" say which. */
		id = strstr(line, "\"channel\":\"");
		r = strstr(line, "\"r_ohm\":");
		if (strstr(line, "\"class\":\"READING\"") && id && r)
			printf("%.*s %g ohm\n", (int)strcspn(id + 11, "\""), id + 11, strtod(r + 8, NULL));
		fflush(stdout);
	}
	fputs("cermd closed the connection\n", stderr);
	return 1;
}
