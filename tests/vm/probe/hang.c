// SPDX-License-Identifier: MIT OR Apache-2.0
/* hang PID NAME: stops the thread of that name, and no other of the process, as if it hung in a call, until it is killed. */
#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ptrace.h>
#include <sys/wait.h>

static int thread_of(const char *pid, const char *name)
{
	char path[512], found[32];
	struct dirent *entry;

	snprintf(path, sizeof(path), "/proc/%s/task", pid);
	DIR *tasks = opendir(path);
	while (tasks && (entry = readdir(tasks))) {
		snprintf(path, sizeof(path), "/proc/%s/task/%.16s/comm", pid, entry->d_name);
		FILE *file = fopen(path, "r");
		if (!file)
			continue;
		if (!fgets(found, sizeof(found), file))
			found[0] = 0;
		fclose(file);
		found[strcspn(found, "\n")] = 0;
		if (strcmp(found, name) == 0)
			return atoi(entry->d_name);
	}
	return 0;
}

int main(int argc, char **argv)
{
	int thread = argc > 2 ? thread_of(argv[1], argv[2]) : 0, status;

	if (!thread || ptrace(PTRACE_SEIZE, thread, 0, 0) || ptrace(PTRACE_INTERRUPT, thread, 0, 0)) {
		perror("no such thread");
		return 1;
	}
	printf("thread %d hangs\n", thread);
	fflush(stdout);
	do {
		if (waitpid(thread, &status, __WALL) < 0)
			return 1;
	} while (!WIFEXITED(status) && !WIFSIGNALED(status));
	return 0;
}
